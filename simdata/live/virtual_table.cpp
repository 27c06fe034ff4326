#include "simdata/live/virtual_table.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "core/base/parse_number.h"
#include "core/base/seconds.h"
#include "core/base/system_call.h"

namespace rigcal::sim {
namespace {

constexpr int look_ms = 10;
constexpr double rest_s = 0.2;  // So long a followed run must not have turned to be at rest.
constexpr double least_turn_deg = 1e-3;

constexpr const char* welcome = "\r\nGrbl 1.1h ['$' for help]\r\n";
constexpr char soft_reset = 0x18;

/// Characters that are not part of a line.
bool is_realtime(char c) { return c == '?' || c == '!' || c == '~' || c == soft_reset; }

double now_s() { return seconds_of_ns(monotonic_now_ns()); }

Error no_terminal(int code) { return call_error("no pseudo-terminal can be had", code, "virtual turntable"); }

std::optional<double> number_at(std::string_view text, std::size_t at) {
  text.remove_prefix(at);
  return take_number<double>(text);
}

}  // namespace

Expected<std::unique_ptr<VirtualTable>> VirtualTable::start(const VirtualTableOptions& options) {
  FileDescriptor terminal(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
  std::array<char, 128> name{};
  if (!terminal.is_open() || ::grantpt(terminal.get()) != 0 || ::unlockpt(terminal.get()) != 0 ||
      ::ptsname_r(terminal.get(), name.data(), name.size()) != 0) {
    return no_terminal(errno);
  }
  FileDescriptor held_open(::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  if (held_open.is_open() && ::tcgetattr(held_open.get(), &settings) == 0) {
    ::cfmakeraw(&settings);
    ::tcsetattr(held_open.get(), TCSANOW, &settings);
  }
  if (!options.link.empty()) {
    struct stat there {};
    if (::lstat(options.link.c_str(), &there) == 0 && S_ISLNK(there.st_mode)) ::unlink(options.link.c_str());
    if (::symlink(name.data(), options.link.c_str()) != 0) {
      return system_error(std::string("cannot be made a link (") + std::strerror(errno) + ")", options.link,
                          "name a place that is free, in a folder of yours");
    }
  }
  return std::unique_ptr<VirtualTable>(
      new VirtualTable(options, std::move(terminal), std::move(held_open), name.data()));
}

VirtualTable::VirtualTable(const VirtualTableOptions& options, FileDescriptor terminal, FileDescriptor held_open,
                           std::string port)
    : options_(options),
      terminal_(std::move(terminal)),
      held_open_(std::move(held_open)),
      port_(std::move(port)),
      told_s_(now_s()) {
  thread_ = std::thread([this] { run(); });
}

VirtualTable::~VirtualTable() {
  is_stopped_ = true;
  thread_.join();
  if (!options_.link.empty()) ::unlink(options_.link.c_str());
}

double VirtualTable::angle_deg() const {
  const std::lock_guard lock(mutex_);
  return angle_deg_;
}

void VirtualTable::follow(double angle_deg) {
  const std::lock_guard lock(mutex_);
  follows_ = true;
  if (is_jammed_ || std::abs(angle_deg - angle_deg_) < least_turn_deg) return;
  angle_deg_ = angle_deg;
  changed_s_ = now_s();
  awaits_turn_ = false;
}

void VirtualTable::advance() {
  const double now = now_s();
  const std::lock_guard lock(mutex_);
  const double most = (now - told_s_) * options_.degrees_per_s;
  told_s_ = now;
  if (!follows_ && !is_jammed_ && !is_held_) angle_deg_ += std::clamp(target_deg_ - angle_deg_, -most, most);
}

bool VirtualTable::is_turning() const {
  if (follows_) return awaits_turn_ || now_s() - changed_s_ < rest_s;
  return angle_deg_ != target_deg_;
}

void VirtualTable::run() {
  if (options_.speaks_grbl) answer(welcome);
  while (!is_stopped_) {
    pollfd wait{terminal_.get(), POLLIN, 0};
    const int ready = ::poll(&wait, 1, look_ms);
    advance();
    if (ready <= 0) continue;
    std::array<char, 256> bytes{};
    const ssize_t got = ::read(terminal_.get(), bytes.data(), bytes.size());
    for (ssize_t i = 0; i < got; ++i) take(bytes[static_cast<std::size_t>(i)]);
  }
}

void VirtualTable::take(char c) {
  if (options_.speaks_grbl && is_realtime(c)) {
    obey(c);
  } else if (c == '\n') {
    take_line();
    line_.clear();
  } else if (c != '\r' && line_.size() < 200) {
    line_ += c;
  }
}

void VirtualTable::obey(char c) {
  const std::lock_guard lock(mutex_);
  if (c == '!') is_held_ = !follows_;
  if (c == '~') is_held_ = false;
  if (c == soft_reset) {
    is_held_ = false;
    target_deg_ = angle_deg_;
    line_.clear();
    answer(welcome);
  }
  if (c != '?') return;
  const char* state = is_held_ ? "Hold:0" : is_turning() ? "Run" : "Idle";
  std::array<char, 96> report{};
  std::snprintf(report.data(), report.size(), "<%s|MPos:%.3f,0.000,0.000|FS:0,0>\r\n", state, angle_deg_);
  answer(report.data());
}

void VirtualTable::order_move(double to_deg) {
  target_deg_ = to_deg;
  awaits_turn_ = follows_;
}

void VirtualTable::take_line() {
  const std::lock_guard lock(mutex_);
  if (options_.speaks_grbl) {
    if (is_held_) return;  // It would wait until it is let go.
    const std::size_t at = line_.find(" X");
    const auto by = at == std::string::npos ? std::nullopt : number_at(line_, at + 2);
    if (line_.find("G91") == std::string::npos || line_.find("G1 ") == std::string::npos || !by) {
      answer("error:20\r\n");
      return;
    }
    order_move((follows_ ? angle_deg_ : target_deg_) + *by);
    answer("ok\r\n");
  } else if (line_ == "POS?") {
    // One that is on its way is not where it is to go, whatever the run's angle is.
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "POS %.3f\n", angle_deg_);
    answer(text.data());
  } else if (const auto to = line_.starts_with("MOVE ") ? number_at(line_, 5) : std::nullopt) {
    order_move(*to);
  } else {
    answer("ERR what?\n");
  }
}

void VirtualTable::answer(const std::string& text) const {
  if (::write(terminal_.get(), text.data(), text.size()) < 0) return;  // Nobody listens.
}

}  // namespace rigcal::sim
