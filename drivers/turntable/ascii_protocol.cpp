#include "drivers/turntable/ascii_protocol.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace rigcal::turntable {
namespace {

constexpr std::string_view angle_place = "{angle}";
constexpr std::string_view step_place = "{step}";
constexpr std::size_t longest = 200;

bool is_one_line(const std::string& text) {
  for (const char c : text) {
    if (c < ' ' || c > '~') return false;
  }
  return text.size() <= longest;
}

std::string filled(std::string text, std::string_view place, double value) {
  std::array<char, 32> number{};
  std::snprintf(number.data(), number.size(), "%.3f", value);
  for (std::size_t at = text.find(place); at != std::string::npos; at = text.find(place))
    text.replace(at, place.size(), number.data());
  return text;
}

}  // namespace

std::string fault_of(const AsciiOptions& options) {
  for (const std::string* text : {&options.move, &options.ask, &options.answer, &options.done, &options.fault}) {
    if (!is_one_line(*text)) return "'" + text->substr(0, 40) + "' is not one line of plain ASCII";
  }
  if (options.move.find(angle_place) == std::string::npos && options.move.find(step_place) == std::string::npos)
    return "move has neither {angle} nor {step} in it";
  if (!options.ask.empty() && options.answer.find(angle_place) == std::string::npos)
    return "answer has no {angle} in it";
  if (options.ask.empty() && options.done.empty()) return "without ask or done nobody knows when the table has arrived";
  return {};
}

void AsciiProtocol::open(double /*now_s*/) {
  lines_ = LineSplitter();
  to_turn_.reset();
  if (!may_repeat()) {
    angle_deg_ = angle_deg_.value_or(0.0);  // As good as any.
    return;
  }
  is_moving_ = false;
  has_target_ = false;
  if (!options_.ask.empty()) {
    angle_deg_.reset();
    return;
  }
  // It counts from where it is now; what is told of it goes on.
  offset_deg_ += angle_deg_.value_or(0.0);
  angle_deg_ = 0.0;
}

bool AsciiProtocol::may_repeat() const {
  return !options_.ask.empty() || options_.move.find(angle_place) != std::string::npos;
}

void AsciiProtocol::turn_by(double degrees, double /*now_s*/) {
  if (is_moving_ && !may_repeat()) return;
  to_turn_ = degrees;
  if (angle_deg_) send_move();
}

void AsciiProtocol::send_move() {
  double step_deg = *to_turn_;
  if (!is_moving_) {
    target_deg_ = (has_target_ ? target_deg_ : *angle_deg_) + step_deg;
  } else if (!options_.ask.empty()) {
    step_deg = std::remainder(target_deg_ - *angle_deg_, 360.0);  // What is missing; it may count within a turn.
  }
  has_target_ = true;
  say(filled(filled(options_.move, angle_place, target_deg_), step_place, step_deg) + "\n");
  to_turn_.reset();
  is_moving_ = true;
  answers_there_ = 0;
}

void AsciiProtocol::receive(std::string_view bytes, double /*now_s*/) {
  for (const std::string& line : lines_.add(bytes)) take_line(line);
}

void AsciiProtocol::tick(double /*now_s*/) {
  if (!options_.ask.empty()) say(options_.ask + "\n");
}

void AsciiProtocol::take_line(const std::string& line) {
  if (!options_.done.empty() && line == options_.done) {
    if (is_moving_) arrive();
    return;
  }
  if (!options_.fault.empty() && line.starts_with(options_.fault)) {
    is_moving_ = false;
    has_target_ = false;
    tell({TableNews::Kind::failed, offset_deg_ + angle_deg_.value_or(0.0), "the table says " + line});
    return;
  }
  if (options_.ask.empty()) return;
  const std::string before = options_.answer.substr(0, options_.answer.find(angle_place));
  double angle = 0.0;
  if (line.starts_with(before) && read_number(std::string_view(line).substr(before.size()), angle)) take_angle(angle);
}

void AsciiProtocol::take_angle(double angle_deg) {
  angle_deg_ = angle_deg;
  tell({TableNews::Kind::angle, angle_deg, {}});
  if (to_turn_) {
    send_move();
    return;
  }
  if (!is_moving_ || !options_.done.empty()) return;
  // Tables that count within a turn are where they were told to be, too.
  const bool is_there = std::abs(std::remainder(angle_deg - target_deg_, 360.0)) <= most_off_deg;
  answers_there_ = is_there ? answers_there_ + 1 : 0;
  if (answers_there_ >= 2) arrive();
}

void AsciiProtocol::arrive() {
  is_moving_ = false;
  if (options_.ask.empty()) {
    angle_deg_ = target_deg_;
    tell({TableNews::Kind::angle, offset_deg_ + target_deg_, {}});
  }
  tell({TableNews::Kind::arrived, offset_deg_ + *angle_deg_, {}});
}

}  // namespace rigcal::turntable
