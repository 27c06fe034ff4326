#include "apps/common/console.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace rigcal {
namespace {

// Often enough to see that it moves, seldom enough for a log file and a slow ssh line.
constexpr std::chrono::milliseconds line_period(2000);
constexpr std::chrono::milliseconds bar_period(100);
constexpr std::chrono::milliseconds block_period(5000);
constexpr int bar_width = 30;
constexpr std::size_t terminal_columns = 79;  // What wraps could not be erased any more.

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
  for (const std::string& line : lines) {
    if (options_.terminal) {
      out_ << on_one_line(line).substr(0, terminal_columns) << '\n';
    } else {
      out_ << "rigcal: " << on_one_line(line) << '\n';
    }
  }
  out_ << std::flush;
  if (options_.terminal) block_lines_ = lines.size();
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
  bar_.resize(std::min(bar_.size(), terminal_columns));
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
