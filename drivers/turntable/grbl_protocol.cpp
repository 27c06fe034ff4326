#include "drivers/turntable/grbl_protocol.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace rigcal::turntable {
namespace {

constexpr double start_up_s = 2.0;  // Opening the port restarts many boards.
constexpr std::string_view letters = "XYZABC";
constexpr double most_deg = 1e6;  // As `read_number`.
constexpr std::string_view soft_reset = "\x18";

// The n-th of the numbers between commas after `name` in a report.
std::optional<double> position(std::string_view report, std::string_view name, std::size_t index) {
  const std::size_t at = report.find(name);
  if (at == std::string_view::npos) return std::nullopt;
  std::string_view rest = report.substr(at + name.size());
  rest = rest.substr(0, rest.find_first_of("|>"));
  for (; index > 0; --index) {
    const std::size_t comma = rest.find(',');
    if (comma == std::string_view::npos) return std::nullopt;
    rest.remove_prefix(comma + 1);
  }
  double value = 0.0;
  if (!read_number(rest, value)) return std::nullopt;
  return value;
}

}  // namespace

void GrblProtocol::open(double now_s) {
  lines_ = LineSplitter();
  to_turn_.reset();
  is_moving_ = false;
  is_taken_ = false;
  is_held_ = false;
  has_reported_ = false;
  may_free_ = true;
  restart(now_s);
}

void GrblProtocol::restart(double now_s) {
  ready_s_ = now_s + start_up_s;
  is_ready_ = false;
}

void GrblProtocol::turn_by(double degrees, double /*now_s*/) {
  // A move that it has taken it will finish, and does another after that, not instead. While it is held it keeps what
  // it is told for later.
  if (is_moving_ && (is_taken_ || is_held_)) return;
  const bool is_known = is_moving_ && start_deg_ && angle_deg_;
  to_turn_ = is_known ? *start_deg_ + moved_by_ - *angle_deg_ : degrees;
  send_if_possible();
}

void GrblProtocol::send_if_possible() {
  if (to_turn_ && is_ready_ && has_reported_ && !is_held_) send_move();
}

void GrblProtocol::send_move() {
  std::array<char, 80> line{};
  std::snprintf(line.data(), line.size(), "G91 G21 G94 G1 %c%.3f F%.1f\n", options_.letter, *to_turn_,
                60.0 * options_.degrees_per_s);
  say(line.data());
  start_deg_ = angle_deg_;
  moved_by_ = *to_turn_;
  to_turn_.reset();
  is_moving_ = true;
  is_taken_ = false;
  asked_after_taken_ = 0;
}

void GrblProtocol::receive(std::string_view bytes, double now_s) {
  for (const std::string& line : lines_.add(bytes)) take_line(line, now_s);
}

void GrblProtocol::tick(double now_s) {
  if (!is_ready_ && now_s >= ready_s_) {
    is_ready_ = true;
    send_if_possible();
  }
  if (!is_ready_) return;
  if (is_taken_) ++asked_after_taken_;
  say("?");
}

void GrblProtocol::take_line(const std::string& line, double now_s) {
  if (line == "ok") {
    is_taken_ = is_moving_;
    asked_after_taken_ = 0;
  } else if (line.starts_with("error:") || line.starts_with("ALARM:")) {
    is_moving_ = false;
    is_taken_ = false;
    tell({TableNews::Kind::failed, angle_deg_.value_or(0.0), "the table says " + line});
  } else if (line.starts_with("Grbl")) {
    if (is_moving_) tell({TableNews::Kind::failed, angle_deg_.value_or(0.0), "the table has restarted"});
    is_moving_ = false;
    is_taken_ = false;
    is_held_ = false;
    has_reported_ = false;
    has_restarted_ = true;
  } else if (line.starts_with('<') && line.ends_with('>')) {
    take_report(line, now_s);
  }
}

void GrblProtocol::take_report(const std::string& line, double now_s) {
  const std::size_t axis = letters.find(options_.letter);
  std::optional<double> counted_deg = position(line, "|MPos:", axis);
  if (!counted_deg) counted_deg = position(line, "|WPos:", axis);
  if (!counted_deg) return;
  take_angle(*counted_deg);
  take_state(line.substr(1, line.find('|') - 1), now_s);
  send_if_possible();
  // The first report after "ok" may have been on its way already.
  if (!is_moving_ || !is_taken_ || asked_after_taken_ < 2 || !line.starts_with("<Idle")) return;
  is_moving_ = false;
  is_taken_ = false;
  const double off = start_deg_ ? *angle_deg_ - *start_deg_ - moved_by_ : 0.0;
  if (std::abs(off) > most_off_deg) {
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), "the table stopped %.2f degrees off where it was told to go", off);
    tell({TableNews::Kind::failed, *angle_deg_, text.data()});
  } else {
    tell({TableNews::Kind::arrived, *angle_deg_, {}});
  }
}

void GrblProtocol::take_angle(double counted_deg) {
  if (std::exchange(has_restarted_, false) && angle_deg_) offset_deg_ = *angle_deg_ - counted_deg;
  if (std::abs(counted_deg + offset_deg_) > most_deg) offset_deg_ = 0.0;
  angle_deg_ = counted_deg + offset_deg_;
  has_reported_ = true;
  tell({TableNews::Kind::angle, *angle_deg_, {}});
}

// What keeps it from turning is told once, also while it rests: somebody has to go there.
void GrblProtocol::take_state(const std::string& state, double now_s) {
  const bool is_alarm = state.starts_with("Alarm");
  const bool is_hold = state.starts_with("Hold");
  is_held_ = is_hold || state.starts_with("Door");
  may_free_ = may_free_ && is_hold;
  if (may_free_) {
    // `close` has left it held within a move. A reset drops the rest of that; of a table that stands it costs no steps,
    // and grbl keeps its position. An alarm, or a hold that comes later, is for somebody to look at.
    if (state == "Hold:1") return;  // It still slows down.
    may_free_ = false;
    say(soft_reset);
    restart(now_s);
    return;
  }
  if (is_alarm) {
    is_moving_ = false;
    is_taken_ = false;
  }
  const std::string kind = is_alarm || is_held_ ? state.substr(0, state.find(':')) : std::string();
  if (std::exchange(told_state_, kind) == kind || kind.empty()) return;
  tell({TableNews::Kind::failed, *angle_deg_,
        "the table says " + state + (is_alarm ? ": unlock it ($X) or home it ($H)" : ": let it go on (~)")});
}

}  // namespace rigcal::turntable
