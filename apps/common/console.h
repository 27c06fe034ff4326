#pragma once

#include <functional>
#include <mutex>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/base/seconds.h"

namespace rigcal {

/// What reaches the user besides results; each level shows itself and all that follow.
enum class LogLevel { debug, info, warning, error };

/// Of a terminal, in characters; one that does not say is taken for the usual one.
struct TerminalSize {
  std::size_t columns = 80;
  std::size_t rows = 24;
};

/// How a console talks. `terminal`: the stream is one, so that a bar may be drawn over itself.
struct ConsoleOptions {
  bool terminal = false;
  bool quiet = false;  ///< No progress; warnings and errors still come.
  LogLevel level = LogLevel::info;
  bool journal = false;  ///< The stream is the system's journal: lines begin with their priority, no tables.
  std::function<TerminalSize()> size = {};  ///< Asked each time that something is drawn: a window may be made smaller.
};

/// The size of the terminal behind `descriptor`.
[[nodiscard]] TerminalSize terminal_size(int descriptor);

/// Whether standard error goes to the journal of a service ($JOURNAL_STREAM names its device and inode).
[[nodiscard]] bool is_journal(const char* journal_stream, int descriptor);

/// Progress, warnings and errors as text on one stream (stderr): a bar on a terminal, plain lines at most every two
/// seconds elsewhere. Callable from any thread.
class ConsoleReporter final : public Reporter {
 public:
  /// `now` is for tests; the stream must outlive the reporter.
  explicit ConsoleReporter(std::ostream& out, std::function<SteadyClock::time_point()> now = SteadyClock::now);
  ~ConsoleReporter() override;
  ConsoleReporter(const ConsoleReporter&) = delete;
  ConsoleReporter& operator=(const ConsoleReporter&) = delete;

  void configure(const ConsoleOptions& options);

  void progress(std::string_view stage, double fraction) override;
  /// Progress of several lines: on a terminal drawn over themselves, elsewhere printed at most every five seconds. What
  /// the terminal has no room for is left out from the end, and a last line says so.
  void block(const std::vector<std::string>& lines);
  /// Something that happened, as a line; not on a terminal, where the block shows it.
  void news(std::string_view line);
  /// A line that the user needs, on a terminal, too.
  void say(std::string_view line);
  /// Shown once, however often it is said.
  void warn(std::string message) override;
  void debug(std::string message) override;

  /// "rigcal: error: ..." in one line.
  void error(std::string_view message);
  /// Takes a bar that stands on the terminal away, before anything else is printed.
  void clear();
  /// All warnings so far, in order, each once.
  [[nodiscard]] std::vector<std::string> warnings() const;

 private:
  void draw_bar(std::string_view stage, double fraction);
  void draw_block(const std::vector<std::string>& lines);
  void erase_bar();
  void print_line(LogLevel level, std::string_view message);

  std::ostream& out_;
  std::function<SteadyClock::time_point()> now_;
  mutable std::mutex mutex_;
  ConsoleOptions options_;
  SteadyClock::time_point last_print_;
  std::string bar_;
  std::size_t block_lines_ = 0;  ///< That stand on the terminal.
  std::vector<std::string> warnings_;
};

}  // namespace rigcal
