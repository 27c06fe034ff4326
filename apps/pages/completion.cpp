#include "apps/pages/completion.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>
#include <vector>

#include "apps/commands/command_line.h"

namespace rigcal {
namespace {

std::vector<const CLI::Option*> named_options(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return !option->get_positional(); });
}

std::string spaced(std::string list) {
  std::replace(list.begin(), list.end(), ',', ' ');
  return list;
}

/// The words that an option takes, "a b c", as its check lists them in braces; empty where it takes others.
std::string words_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto begin = type.find('{');
  const auto end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos || end < begin) return {};
  return spaced(type.substr(begin + 1, end - begin - 1));
}

std::string option_names(const CLI::App& app) {
  std::string names;
  for (const CLI::Option* option : named_options(app)) names += spaced(option->get_name(false, true)) + " ";
  return names;
}

void append_words(std::ostringstream& out, const CLI::App& app, const std::string& command) {
  for (const CLI::Option* option : named_options(app)) {
    const std::string words = words_of(*option);
    if (words.empty()) continue;
    for (const std::string& name : option->get_lnames()) {
      out << "    " << command << ":--" << name << ") COMPREPLY=($(compgen -W \"" << words
          << "\" -- \"$word\")); return ;;\n";
    }
  }
}

/// For single quotes of a shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("\\'") : std::string(1, c);
  return out + "'";
}

void append_fish_options(std::ostringstream& out, const CLI::App& app, const std::string& condition) {
  for (const CLI::Option* option : named_options(app)) {
    out << "complete -c rigcal" << condition;
    for (const std::string& name : option->get_lnames()) out << " -l " << name;
    for (const std::string& name : option->get_snames()) out << " -s " << name;
    if (option->get_type_size() != 0) out << " -r";
    if (const std::string words = words_of(*option); !words.empty()) out << " -f -a " << quoted(words);
    out << " -d " << quoted(option->get_description()) << "\n";
  }
}

// Within the brackets of an _arguments specification.
std::string zsh_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return out;
}

void append_zsh_options(std::ostringstream& out, const CLI::App& app) {
  for (const CLI::Option* option : named_options(app)) {
    std::vector<std::string> names;
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    const std::string words = words_of(*option);
    for (const std::string& name : names) {
      out << " \\\n        '*" << name << "[" << zsh_text(option->get_description()) << "]";
      if (option->get_type_size() != 0) out << ":" << (words.empty() ? "value:_files" : "word:(" + words + ")");
      out << "'";
    }
  }
}

}  // namespace

std::string bash_completion(const CLI::App& program) {
  std::ostringstream out;
  out << "# bash completion of rigcal\n_rigcal() {\n"
         "  local word=\"${COMP_WORDS[COMP_CWORD]}\" before=\"${COMP_WORDS[COMP_CWORD-1]}\" command= each\n"
         "  for each in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n    case \"$each\" in\n      ";
  std::string names;
  for (const CLI::App* command : commands_of(program)) names += (names.empty() ? "" : "|") + command->get_name();
  out << names << ") command=$each; break ;;\n    esac\n  done\n  case \"$command:$before\" in\n";
  append_words(out, program, "*");
  for (const CLI::App* command : commands_of(program)) append_words(out, *command, command->get_name());
  out << "  esac\n  local options=\"" << option_names(program) << "\"\n  case \"$command\" in\n";
  for (const CLI::App* command : commands_of(program)) {
    out << "    " << command->get_name() << ") options+=\"" << option_names(*command) << "\" ;;\n";
  }
  std::replace(names.begin(), names.end(), '|', ' ');
  out << "    *) options+=\"" << names << "\" ;;\n  esac\n"
      << "  if [[ -z $command || $word == -* ]]; then\n"
         "    COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n  else\n"
         "    COMPREPLY=($(compgen -f -- \"$word\"))\n  fi\n}\ncomplete -o filenames -F _rigcal rigcal\n";
  return out.str();
}

std::string fish_completion(const CLI::App& program) {
  std::ostringstream out;
  out << "# fish completion of rigcal\n";
  append_fish_options(out, program, "");
  for (const CLI::App* command : commands_of(program)) {
    out << "complete -c rigcal -n __fish_use_subcommand -f -a " << command->get_name() << " -d "
        << quoted(command->get_description()) << "\n";
    append_fish_options(out, *command, " -n '__fish_seen_subcommand_from " + command->get_name() + "'");
  }
  return out.str();
}

std::string zsh_completion(const CLI::App& program) {
  std::ostringstream out;
  out << "#compdef rigcal\n_rigcal() {\n  local curcontext=\"$curcontext\" state line\n  local -a commands\n  "
         "commands=(\n";
  for (const CLI::App* command : commands_of(program)) {
    out << "    '" << command->get_name() << ":" << zsh_text(command->get_description()) << "'\n";
  }
  out << "  )\n  _arguments -C";
  append_zsh_options(out, program);
  out << " \\\n        '1:command:->command' '*::argument:->argument'\n"
         "  case $state in\n    command) _describe command commands ;;\n    argument)\n      case $line[1] in\n";
  for (const CLI::App* command : commands_of(program)) {
    out << "      " << command->get_name() << ") _arguments";
    append_zsh_options(out, program);
    append_zsh_options(out, *command);
    out << " \\\n        '*:file:_files' ;;\n";
  }
  out << "      esac ;;\n  esac\n}\n_rigcal \"$@\"\n";
  return out.str();
}

}  // namespace rigcal
