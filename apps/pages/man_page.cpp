#include "apps/pages/man_page.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <sstream>
#include <utility>
#include <vector>

#include "apps/commands/command_line.h"
#include "core/base/version.h"

namespace rigcal {
namespace {

/// Text for troff: hyphens that can be copied, no line that looks like a request.
std::string escaped(const std::string& text) {
  std::string out;
  bool line_start = true;
  for (const char c : text) {
    if (line_start && (c == '.' || c == '\'')) out += "\\&";
    if (c == '-' || c == '\\') out += '\\';
    out += c == '\\' ? 'e' : c;
    line_start = c == '\n';
  }
  return out;
}

/// "\-\-quiet, \-q", then what it takes.
std::string option_head(const CLI::Option& option) {
  const bool positional = option.get_positional();
  std::string names = escaped(positional ? option.get_name(true) : option.get_name(false, true));
  if (const auto comma = names.find(','); comma != std::string::npos) names.insert(comma + 1, " ");
  std::string head = (positional ? ".I " : ".B ") + names;
  if (!positional && option.get_type_size() != 0 && !option.get_option_text().empty()) {
    head += " \\fI" + escaped(option.get_option_text()) + "\\fR";
  }
  return head;
}

void append_options(std::ostringstream& out, const CLI::App& app, const char* title) {
  out << ".SH " << title << "\n";
  for (const CLI::Option* option : app.get_options()) {
    std::string text = option->get_description();
    if (option->get_required()) text += " (must be given)";
    out << ".TP\n" << option_head(*option) << "\n" << escaped(text) << "\n";
  }
}

std::string synopsis(const CLI::App& app) {
  std::string text = "[\\fIOPTIONS\\fR]";
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_positional()) {
      text += " \\fI" + escaped(option->get_name(true)) + "\\fR";
    } else if (option->get_required()) {
      text +=
          " \\fB" + escaped(option->get_name(false, false)) + "\\fR \\fI" + escaped(option->get_option_text()) + "\\fR";
    }
  }
  return text;
}

void append_exit_codes(std::ostringstream& out) {
  const std::vector<std::pair<int, const char*>> codes{
      {0, "done, and good"},
      {1, "done, but a result is not trustworthy or a recording not whole; or stopped by Ctrl-C, with nothing written"},
      {2, "the command line is wrong"},
      {3, "an input is missing, unreadable, damaged or contradictory; the message names the place and the mend"},
      {4, "a device, the network or the system refused; the message says what to do"}};
  out << ".SH EXIT STATUS\n";
  for (const auto& [code, text] : codes) out << ".TP\n.B " << code << "\n" << escaped(text) << "\n";
}

}  // namespace

std::string man_page(const CLI::App& program, const CLI::App* command) {
  const std::string title = command == nullptr ? "rigcal" : "rigcal-" + command->get_name();
  const CLI::App& app = command == nullptr ? program : *command;
  std::string description = app.get_description();
  if (command == nullptr) description = description.substr(description.find(": ") + 2);
  std::string upper = title;
  std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
  std::ostringstream out;
  out << ".TH " << escaped(upper) << " 1 \"\" \"rigcal " << version() << "\" \"rigcal\"\n";
  out << ".SH NAME\n" << escaped(title) << " \\- " << escaped(description) << "\n";
  out << ".SH SYNOPSIS\n.B rigcal\n";
  if (command == nullptr) {
    out << "\\fICOMMAND\\fR [\\fIOPTIONS\\fR]\n.SH COMMANDS\n";
    for (const CLI::App* each : commands_of(program)) {
      out << ".TP\n.BR rigcal\\-" << escaped(each->get_name()) << " (1)\n" << escaped(each->get_description()) << "\n";
    }
    append_options(out, program, "OPTIONS OF EVERY COMMAND");
  } else {
    out << "\\fB" << escaped(command->get_name()) << "\\fR " << synopsis(*command) << "\n";
    append_options(out, *command, "OPTIONS");
    out << ".PP\nThe options that every command has, " << escaped(global_option_names) << ", are in\n.BR rigcal (1).\n";
  }
  append_exit_codes(out);
  const std::string footer = app.get_footer();
  const std::string mark = "Example:\n";
  if (const auto at = footer.find(mark); at != std::string::npos) {
    out << ".SH EXAMPLES\n.nf\n" << escaped(footer.substr(at + mark.size())) << "\n.fi\n";
  }
  out << ".SH SEE ALSO\n";
  if (command != nullptr) out << ".BR rigcal (1)\n.PP\n";
  out << "The manual, in the folder of the documentation of the package: manual.md.\n";
  return out.str();
}

}  // namespace rigcal
