#include "apps/commands/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/commands/known_files.h"
#include "core/base/version.h"

namespace rigcal {
namespace {

void add_global_options(CLI::App& app, CommandContext& context, GlobalOptions& options) {
  app.set_version_flag("--version", std::string("rigcal ") + version());
  app.add_flag("--quiet,-q", context.quiet, "No progress and no summary, only warnings and errors");
  app.add_flag("--json", context.json, "Print the summary as one JSON object on stdout");
  app.add_option("--log-level", options.level, "What to tell on stderr: debug, info (default), warning or error")
      ->check(CLI::IsMember({"debug", "info", "warning", "error"}))
      ->option_text("LEVEL");
  app.add_option("--threads", options.threads, "Threads to use (default: all cores); no result depends on it")
      ->check(CLI::Range(1, 1024))
      ->option_text("N");
}

// The commands in the order in which --help lists them.
void add_commands(CLI::App& app, CommandContext& context) {
  add_simulate_command(app, context);
  add_capture_command(app, context);
  add_calibrate_command(app, context);
  add_batch_command(app, context);
  add_inspect_command(app, context);
  add_import_command(app, context);
  add_export_command(app, context);
  add_evaluate_command(app, context);
  add_experiment_command(app, context);
  add_replay_command(app, context);
  add_doctor_command(app, context);
}

std::vector<CLI::App*> all_commands(CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

/// The help of a command lists its own options only.
void point_to_common_options(CLI::App& app) {
  for (CLI::App* command : all_commands(app))
    command->footer(global_option_names + std::string(": see rigcal --help\n\n") + command->get_footer());
}

/// Wherever a rig file is asked for, the name of one that comes with the program does too.
void let_rigs_be_named(CLI::App& app) {
  for (CLI::App* command : all_commands(app)) {
    CLI::Option* rig = command->get_option_no_throw("--rig");
    if (rig == nullptr) continue;
    rig->transform(CLI::Validator(
        [](std::string& given) {
          given = rig_file(given);
          return std::string();
        },
        ""));
  }
}

// CLI11 only says that a subcommand is missing, also where there is one that it does not know.
std::string usage_error(const CLI::App& app, const CLI::ParseError& error) {
  if (app.get_subcommands().empty()) {
    for (const std::string& word : app.remaining()) {
      if (word.empty() || word[0] != '-') return "there is no command '" + word + "'; see rigcal --help";
    }
    return std::string(error.what()) + "; see rigcal --help";
  }
  return std::string(error.what()) + "; see rigcal " + app.get_subcommands().front()->get_name() + " --help";
}

}  // namespace

const std::map<std::string, LogLevel>& log_levels() {
  static const std::map<std::string, LogLevel> levels{
      {"debug", LogLevel::debug}, {"info", LogLevel::info}, {"warning", LogLevel::warning}, {"error", LogLevel::error}};
  return levels;
}

void CommandContext::print(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }

void describe_command_line(CLI::App& app, CommandContext& context, GlobalOptions& options) {
  app.description("rigcal: extrinsics of rigs of LiDARs and cameras, from a recording of a turntable run");
  app.name("rigcal");
  app.footer("Example:\n  rigcal calibrate run.pcap --rig rig.yaml --out result\nManual: docs/manual.md");
  app.fallthrough();  // the global options may stand behind the subcommand too
  app.require_subcommand(1);
  add_global_options(app, context, options);
  add_commands(app, context);
  let_rigs_be_named(app);
  point_to_common_options(app);
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::optional<ExitCode> parse_command_line(int argc, char** argv, CommandContext& context, GlobalOptions& options) {
  CLI::App app;
  describe_command_line(app, context, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help and --version
      app.exit(error);
      return ExitCode::good;
    }
    context.reporter.error(usage_error(app, error));
    return ExitCode::usage;
  }
  return std::nullopt;
}

}  // namespace rigcal
