#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <thread>

#include "apps/cameras/camera_recorder.h"
#include "apps/commands/command_line.h"
#include "apps/common/stop_signal.h"
#include "core/base/parallel.h"

namespace rigcal {
namespace {

// Where one of them is closed (`2>&-`, some job systems) the first file that is opened would get its number, and what
// is said would be written into it.
void open_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    if (fcntl(stream, F_GETFD) == -1) static_cast<void>(open("/dev/null", O_RDWR));  // The lowest free number: this.
  }
}

int finish(CommandContext& context, ExitCode code) {
  context.reporter.clear();
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    context.reporter.error("cannot write to standard output; free disk space or check where it is sent to");
    return static_cast<int>(ExitCode::system);
  }
  return static_cast<int>(code);
}

int run_program(int argc, char** argv, ConsoleReporter& reporter) {
  const StopSignal stop_signal;
  CommandContext context{reporter, stop_signal.token(), false, false, {}};
  GlobalOptions options;
  if (const auto end = parse_command_line(argc, argv, context, options)) return finish(context, *end);

  reporter.configure({isatty(STDERR_FILENO) == 1, context.quiet, log_levels().at(options.level),
                      is_journal(std::getenv("JOURNAL_STREAM"), STDERR_FILENO),
                      [] { return terminal_size(STDERR_FILENO); }});
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

}  // namespace rigcal

int main(int argc, char** argv) {
  using rigcal::ExitCode;
  rigcal::open_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // A file that may not grow is an error like a full disk, and no end of the program.
  rigcal::ConsoleReporter reporter(std::cerr);
  try {
    const int code = rigcal::run_program(argc, argv, reporter);
    // Everything is written; only a thread that waits for a camera is left, and must not find its world destroyed.
    if (rigcal::CameraRecorder::has_left_a_camera()) std::_Exit(code);
    return code;
  } catch (const std::bad_alloc&) {
    reporter.error("out of memory; use a machine with more, or a shorter recording");
  } catch (const std::exception& error) {
    reporter.error(std::string("unexpected: ") + error.what() + "; please report this as a bug");
  }
  return static_cast<int>(ExitCode::system);
}
