#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <map>
#include <new>
#include <string>
#include <thread>

#include "apps/command.h"
#include "apps/stop_signal.h"
#include "core/base/parallel.h"
#include "core/base/version.h"

namespace rigcal {
namespace {

struct GlobalOptions {
  std::string level = "info";
  int threads = 0;
};

const std::map<std::string, LogLevel> levels{
    {"debug", LogLevel::debug}, {"info", LogLevel::info}, {"warning", LogLevel::warning}, {"error", LogLevel::error}};

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
  add_calibrate_command(app, context);
  add_inspect_command(app, context);
  add_export_command(app, context);
  add_evaluate_command(app, context);
}

int finish(CommandContext& context, ExitCode code) {
  context.reporter.clear();
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    context.reporter.error("cannot write to standard output; free disk space or check where it is sent to");
    return static_cast<int>(ExitCode::system);
  }
  return static_cast<int>(code);
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

int run_program(int argc, char** argv, ConsoleReporter& reporter) {
  const StopSignal stop_signal;
  CommandContext context{reporter, stop_signal.token(), false, false, {}};
  GlobalOptions options;

  CLI::App app("rigcal: extrinsics of rigs of LiDARs and cameras, from a recording of a turntable run", "rigcal");
  app.footer("Example:\n  rigcal calibrate run.pcap --rig rig.yaml --out result\nManual: docs/manual.md");
  app.fallthrough();  // the global options may stand behind the subcommand too
  app.require_subcommand(1);
  add_global_options(app, context, options);
  add_commands(app, context);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help and --version
      app.exit(error);
      return finish(context, ExitCode::good);
    }
    reporter.error(usage_error(app, error));
    return static_cast<int>(ExitCode::usage);
  }

  reporter.configure({isatty(STDERR_FILENO) == 1, context.quiet, levels.at(options.level)});
  if (!stop_signal.ready()) reporter.warn(stop_signal.ready().error().message());
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  set_thread_count(options.threads > 0 ? options.threads : std::max(cores, 1));

  const Expected<ExitCode> result = context.run();
  if (!result) {
    reporter.error(result.error().message());
    return finish(context, exit_code_of(result.error()));
  }
  return finish(context, *result);
}

}  // namespace

void CommandContext::print(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }

}  // namespace rigcal

int main(int argc, char** argv) {
  using rigcal::ExitCode;
  rigcal::ConsoleReporter reporter(std::cerr);
  try {
    return rigcal::run_program(argc, argv, reporter);
  } catch (const std::bad_alloc&) {
    reporter.error("out of memory; use a machine with more, or a shorter recording");
  } catch (const std::exception& error) {
    reporter.error(std::string("unexpected: ") + error.what() + "; please report this as a bug");
  }
  return static_cast<int>(ExitCode::system);
}
