#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "apps/common/console.h"
#include "apps/common/exit_code.h"
#include "core/base/error.h"
#include "core/base/run_context.h"

namespace CLI {
class App;
}

namespace rigcal {

/// What every command shares. A command's `add_<name>_command` declares its options and, when it is the one called,
/// sets `run`; main calls that after the whole command line was found right.
struct CommandContext {
  ConsoleReporter& reporter;
  std::stop_token stop;
  bool json = false;   ///< Print the summary as one JSON object on stdout instead of text.
  bool quiet = false;  ///< No progress, no text summary.

  /// Does the work. An Error is printed and mapped to the exit code by main.
  std::function<Expected<ExitCode>()> run;

  [[nodiscard]] RunContext run_context() { return {reporter, stop}; }
  /// Writes a summary to stdout.
  static void print(const std::string& text);
};

/// One file a command. To add one: cmd_<name>.cpp, its line here, in command_line.cpp (`add_commands`) and in
/// CMakeLists.txt:
///
///   void add_inspect_command(CLI::App& app, CommandContext& context) {
///     const auto options = std::make_shared<InspectOptions>();
///     CLI::App* command = app.add_subcommand("inspect", "Show what is in a dump, session, patch folder or result");
///     command->add_option("PATH", options->path, "A dump, session, patch folder or result")->required();
///     command->footer("Example:\n  rigcal inspect run.pcap");
///     command->callback([options, &context] { context.run = [=, &context] { return run_inspect(*options, context); };
///     });
///   }
///
/// Do not let CLI11 check files (exit code 2): a missing input is an Error of kind input (3).

void add_batch_command(CLI::App& app, CommandContext& context);
void add_calibrate_command(CLI::App& app, CommandContext& context);
void add_capture_command(CLI::App& app, CommandContext& context);
void add_doctor_command(CLI::App& app, CommandContext& context);
void add_evaluate_command(CLI::App& app, CommandContext& context);
void add_experiment_command(CLI::App& app, CommandContext& context);
void add_export_command(CLI::App& app, CommandContext& context);
void add_import_command(CLI::App& app, CommandContext& context);
void add_inspect_command(CLI::App& app, CommandContext& context);
void add_replay_command(CLI::App& app, CommandContext& context);
void add_simulate_command(CLI::App& app, CommandContext& context);

}  // namespace rigcal
