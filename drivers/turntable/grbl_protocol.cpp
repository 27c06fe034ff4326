#include "drivers/turntable/grbl_protocol.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace rigcal::turntable {
namespace {

constexpr double start_up_s = 2.0;  // Opening the port restarts many boards.
constexpr double most_off_deg = 0.1;
constexpr std::string_view letters = "XYZABC";

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
  ready_s_ = now_s + start_up_s;
  is_ready_ = false;
}

void GrblProtocol::turn_by(double degrees, double /*now_s*/) {
  // A move that it has taken it will finish, and does another after that, not instead.
  if (is_moving_ && is_taken_) return;
  const bool is_known = is_moving_ && start_deg_ && angle_deg_;
  to_turn_ = is_known ? *start_deg_ + moved_by_ - *angle_deg_ : degrees;
  if (is_ready_) send_move();
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

void GrblProtocol::receive(std::string_view bytes, double /*now_s*/) {
  for (const std::string& line : lines_.add(bytes)) take_line(line);
}

void GrblProtocol::tick(double now_s) {
  if (!is_ready_ && now_s >= ready_s_) {
    is_ready_ = true;
    if (to_turn_ && angle_deg_) send_move();
  }
  if (!is_ready_) return;
  if (is_taken_) ++asked_after_taken_;
  say("?");
}

void GrblProtocol::take_line(const std::string& line) {
  if (line == "ok") {
    is_taken_ = is_moving_;
    asked_after_taken_ = 0;
  } else if (line.starts_with("error:") || line.starts_with("ALARM:")) {
    is_moving_ = false;
    is_taken_ = false;
    tell({TableNews::Kind::failed, angle_deg_.value_or(0.0), "the table says " + line});
  } else if (line.starts_with("Grbl ")) {
    if (is_moving_) tell({TableNews::Kind::failed, angle_deg_.value_or(0.0), "the table has restarted"});
    is_moving_ = false;
    is_taken_ = false;
  } else if (line.starts_with('<') && line.ends_with('>')) {
    take_report(line);
  }
}

void GrblProtocol::take_report(const std::string& line) {
  const std::size_t axis = letters.find(options_.letter);
  std::optional<double> angle = position(line, "|MPos:", axis);
  if (!angle) angle = position(line, "|WPos:", axis);
  if (!angle) return;
  angle_deg_ = angle;
  tell({TableNews::Kind::angle, *angle, {}});
  if (to_turn_ && is_ready_) {
    send_move();
    return;
  }
  if (!is_moving_) return;
  if (line.starts_with("<Alarm") || line.starts_with("<Door")) {
    is_moving_ = false;
    is_taken_ = false;
    tell({TableNews::Kind::failed, *angle, "the table says " + line.substr(1, line.find('|') - 1)});
    return;
  }
  // The first report after "ok" may have been on its way already.
  if (!is_taken_ || asked_after_taken_ < 2 || !line.starts_with("<Idle")) return;
  is_moving_ = false;
  is_taken_ = false;
  const double off = start_deg_ ? *angle - *start_deg_ - moved_by_ : 0.0;
  if (std::abs(off) > most_off_deg) {
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), "the table stopped %.2f degrees off where it was told to go", off);
    tell({TableNews::Kind::failed, *angle, text.data()});
  } else {
    tell({TableNews::Kind::arrived, *angle, {}});
  }
}

}  // namespace rigcal::turntable
