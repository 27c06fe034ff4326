#include "apps/common/console.h"

#include <sys/ioctl.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/text.h"

namespace rigcal {
namespace {

// Often enough to see that it moves, seldom enough for a log file and a slow ssh line.
constexpr std::chrono::milliseconds line_period(2000);
constexpr std::chrono::milliseconds bar_period(100);
constexpr std::chrono::milliseconds block_period(5000);
constexpr int bar_width = 30;
constexpr std::size_t most_columns = 79;

std::string percent(double fraction) {
  return std::to_string(std::lround(std::clamp(fraction, 0.0, 1.0) * 100.0)) + " %";
}

// An error may quote a hostile file: control characters would let it move the cursor or add lines of its own.
std::string on_one_line(std::string_view message) {
  std::string line(message);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  return line;
}

}  // namespace

TerminalSize terminal_size(int descriptor) {
  winsize found{};
  TerminalSize size;
  if (::ioctl(descriptor, TIOCGWINSZ, &found) != 0) return size;
  if (found.ws_col > 0) size.columns = found.ws_col;
  if (found.ws_row > 0) size.rows = found.ws_row;
  return size;
}

bool is_journal(const char* journal_stream, int descriptor) {
  struct stat found {};
  if (journal_stream == nullptr || ::fstat(descriptor, &found) != 0) return false;
  return std::to_string(found.st_dev) + ":" + std::to_string(found.st_ino) == journal_stream;
}

ConsoleReporter::ConsoleReporter(std::ostream& out, std::function<SteadyClock::time_point()> now)
    : out_(out), now_(std::move(now)), last_print_(now_()) {}

ConsoleReporter::~ConsoleReporter() { clear(); }

void ConsoleReporter::configure(const ConsoleOptions& options) {
  const std::lock_guard lock(mutex_);
  options_ = options;
}

void ConsoleReporter::progress(std::string_view stage, double fraction) {
  const std::lock_guard lock(mutex_);
  if (options_.quiet || options_.level > LogLevel::info) return;
  const SteadyClock::time_point now = now_();
  if (now - last_print_ < (options_.terminal ? bar_period : line_period)) return;
  last_print_ = now;
  if (options_.terminal) {
    draw_bar(stage, fraction);
  } else {
    out_ << "rigcal: " << stage << (fraction < 0.0 ? "" : " " + percent(fraction)) << std::endl;
  }
}

void ConsoleReporter::block(const std::vector<std::string>& lines) {
  const std::lock_guard lock(mutex_);
  if (options_.quiet || options_.level > LogLevel::info) return;
  const SteadyClock::time_point now = now_();
  if (options_.journal || (!options_.terminal && now - last_print_ < block_period)) return;
  last_print_ = now;
  erase_bar();
  if (options_.terminal) {
    draw_block(lines);
  } else {
    for (const std::string& line : lines) out_ << "rigcal: " << on_one_line(line) << '\n';
  }
  out_ << std::flush;
}

// What wraps or scrolls out at the top could not be erased any more. Nor does a block begin in the first row: what is
// erased from there on some terminals keep (tmux), as if it had scrolled out.
void ConsoleReporter::draw_block(const std::vector<std::string>& lines) {
  const TerminalSize size = options_.size ? options_.size() : TerminalSize{};
  const std::size_t columns = std::min(most_columns, std::max<std::size_t>(size.columns, 2) - 1);
  const std::size_t room = std::max<std::size_t>(size.rows, 3) - 2;  // the cursor stands below the last line
  const bool fits = lines.size() <= room;
  block_lines_ = fits ? lines.size() : room;
  const std::size_t shown = fits ? lines.size() : room - 1;
  for (std::size_t k = 0; k < shown; ++k) out_ << on_one_line(lines[k]).substr(0, columns) << '\n';
  if (fits) return;
  const std::string rest = counted(lines.size() - shown, "more line") + ": make the window higher";
  out_ << rest.substr(0, columns) << '\n';
}

void ConsoleReporter::say(std::string_view line) {
  const std::lock_guard lock(mutex_);
  if (options_.level <= LogLevel::info) print_line(LogLevel::info, line);
}

void ConsoleReporter::news(std::string_view line) {
  const std::lock_guard lock(mutex_);
  if (options_.quiet || options_.level > LogLevel::info || options_.terminal) return;
  print_line(LogLevel::info, line);
}

void ConsoleReporter::draw_bar(std::string_view stage, double fraction) {
  erase_bar();
  if (fraction < 0.0) {
    bar_ = "[" + std::string(bar_width, '.') + "] " + std::string(stage);
  } else {
    const auto done = static_cast<std::size_t>(std::lround(std::clamp(fraction, 0.0, 1.0) * bar_width));
    bar_ = "[" + std::string(done, '#') + std::string(bar_width - done, ' ') + "] " + percent(fraction) + " " +
           std::string(stage);
  }
  const std::size_t columns = options_.size ? options_.size().columns : TerminalSize{}.columns;
  bar_.resize(std::min({bar_.size(), most_columns, std::max<std::size_t>(columns, 2) - 1}));
  out_ << bar_ << std::flush;
}

void ConsoleReporter::erase_bar() {
  if (block_lines_ > 0) out_ << "\x1b[" << block_lines_ << "A\x1b[J" << std::flush;  // Up, and away with what is below.
  block_lines_ = 0;
  if (bar_.empty()) return;
  out_ << '\r' << std::string(bar_.size(), ' ') << '\r' << std::flush;
  bar_.clear();
}

void ConsoleReporter::print_line(LogLevel level, std::string_view message) {
  struct Kind {
    const char* priority;  // as syslog counts
    const char* prefix;
  };
  constexpr std::array<Kind, 4> kinds{
      {{"<7>", "rigcal: debug: "}, {"<6>", "rigcal: "}, {"<4>", "rigcal: warning: "}, {"<3>", "rigcal: error: "}}};
  const Kind& kind = kinds.at(static_cast<std::size_t>(level));
  erase_bar();
  if (options_.journal) out_ << kind.priority;
  out_ << kind.prefix << on_one_line(message) << std::endl;
}

void ConsoleReporter::warn(std::string message) {
  const std::lock_guard lock(mutex_);
  if (std::find(warnings_.begin(), warnings_.end(), message) != warnings_.end()) return;
  if (options_.level <= LogLevel::warning) print_line(LogLevel::warning, message);
  warnings_.push_back(std::move(message));
}

void ConsoleReporter::debug(std::string message) {
  const std::lock_guard lock(mutex_);
  if (options_.level == LogLevel::debug) print_line(LogLevel::debug, message);
}

void ConsoleReporter::error(std::string_view message) {
  const std::lock_guard lock(mutex_);
  print_line(LogLevel::error, message);
}

void ConsoleReporter::clear() {
  const std::lock_guard lock(mutex_);
  erase_bar();
}

std::vector<std::string> ConsoleReporter::warnings() const {
  const std::lock_guard lock(mutex_);
  return warnings_;
}

}  // namespace rigcal
