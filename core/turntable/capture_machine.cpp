#include "core/turntable/capture_machine.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rigcal {
namespace {

constexpr int most_turns_told = 2;

}  // namespace

const char* to_string(CaptureState state) {
  switch (state) {
    case CaptureState::idle:
      return "idle";
    case CaptureState::checking:
      return "checking";
    case CaptureState::waiting_for_still:
      return "waiting for still";
    case CaptureState::settling:
      return "settling";
    case CaptureState::capturing:
      return "capturing";
    case CaptureState::moving:
      return "moving";
    case CaptureState::ended:
      return "ended";
    case CaptureState::failed:
      return "failed";
  }
  return "";
}

CaptureMachine::CaptureMachine(const CaptureGoal& goal, std::vector<CaptureSensor> sensors) : goal_(goal) {
  for (CaptureSensor& sensor : sensors) sensors_.push_back({std::move(sensor), false, false});
}

std::vector<CaptureAction> CaptureMachine::handle(double now_s, const CaptureInput& input) {
  now_s_ = std::max(now_s_, now_s);
  if (!is_over()) std::visit([this](const auto& what) { on(what); }, input);
  return std::exchange(actions_, {});
}

bool CaptureMachine::is_under_way() const {
  return state_ == CaptureState::waiting_for_still || state_ == CaptureState::settling ||
         state_ == CaptureState::capturing || state_ == CaptureState::moving;
}

bool CaptureMachine::are_all_there() const {
  return std::all_of(sensors_.begin(), sensors_.end(), [](const Seen& seen) { return seen.is_there; });
}

bool CaptureMachine::has_all_images() const {
  return std::all_of(sensors_.begin(), sensors_.end(),
                     [](const Seen& seen) { return !seen.sensor.is_camera || !seen.is_there || seen.has_image; });
}

CaptureMachine::Seen* CaptureMachine::seen(int sensor) {
  const bool is_known = sensor >= 0 && static_cast<std::size_t>(sensor) < sensors_.size();
  return is_known ? &sensors_[static_cast<std::size_t>(sensor)] : nullptr;
}

// Where the rest that is known of puts the machine.
void CaptureMachine::look_at_rest() {
  // While the table turns nothing counts but a rest from before, told of late.
  const bool is_from_before = rest_ == Rest::settled && !is_full_ && place_ < told_s_.size();
  if (table_is_turning_ && !is_from_before) {
    state_ = CaptureState::moving;
    return;
  }
  switch (rest_) {
    case Rest::none:
      state_ = stops_ > 0 && !left_early_ ? CaptureState::moving : CaptureState::waiting_for_still;
      break;
    case Rest::begun:
      state_ = CaptureState::settling;
      break;
    case Rest::settled:
      state_ = CaptureState::capturing;
      check_full();
      break;
  }
}

void CaptureMachine::begin_stop(const happened::RestSettled& input) {
  rest_ = Rest::settled;
  stop_ = input.stop;
  place_ = static_cast<std::size_t>(
      std::count_if(told_s_.begin(), told_s_.end(), [&](double told_s) { return told_s <= input.at_s; }));
  rested_s_ = 0.0;
  is_full_ = place_ < places_in_;  // The other part of it counts.
  for (Seen& seen : sensors_) seen.has_image = false;
}

void CaptureMachine::check_full() {
  if (state_ != CaptureState::capturing || is_full_ || rested_s_ < goal_.dwell_s) return;
  if (has_all_images() || rested_s_ >= goal_.dwell_s + goal_.frame_s) count_stop();
}

void CaptureMachine::count_stop() {
  is_full_ = true;
  left_early_ = false;
  if (goal_.turns_itself) places_in_ = place_ + 1;
  ++stops_;
  actions_.push_back(CaptureAction::secure);
  if (goal_.stops > 0 && stops_ >= goal_.stops) {
    state_ = CaptureState::ended;
    actions_.push_back(CaptureAction::end);
    return;
  }
  // Stops that are found anew are of where the table has turned on from already.
  if (goal_.turns_itself && place_ == told_s_.size()) {
    told_s_.push_back(now_s_);
    turns_told_ = 0;
    turn();
  }
}

void CaptureMachine::turn() {
  ++turns_told_;
  table_is_turning_ = true;
  table_due_s_ = now_s_ + goal_.table_s;
  actions_.push_back(CaptureAction::turn_table);
}

void CaptureMachine::fail(std::string why) {
  state_ = CaptureState::failed;
  failure_ = std::move(why);
  actions_.push_back(CaptureAction::end);
}

void CaptureMachine::on(const happened::Begun&) {
  if (state_ != CaptureState::idle) return;
  begun_s_ = now_s_;
  state_ = CaptureState::checking;
  on(happened::TimePassed{});
}

void CaptureMachine::on(const happened::SensorCame& input) {
  if (Seen* sensor = seen(input.sensor)) sensor->is_there = true;
  on(happened::TimePassed{});
}

void CaptureMachine::on(const happened::SensorWent& input) {
  if (Seen* sensor = seen(input.sensor)) sensor->is_there = false;
  check_full();
}

void CaptureMachine::on(const happened::ImageCame& input) {
  if (Seen* sensor = seen(input.sensor)) sensor->has_image = true;
  check_full();
}

void CaptureMachine::on(const happened::RestBegan&) {
  rest_ = Rest::begun;
  if (is_under_way()) look_at_rest();
}

void CaptureMachine::on(const happened::RestSettled& input) {
  begin_stop(input);
  if (is_under_way()) look_at_rest();
}

void CaptureMachine::on(const happened::Rested& input) {
  if (rest_ != Rest::settled) return;
  rested_s_ = std::max(rested_s_, input.seconds);
  check_full();
}

void CaptureMachine::on(const happened::StopOver& input) {
  if (state_ != CaptureState::capturing || input.stop != stop_ || is_full_) return;
  rest_ = Rest::none;
  if (input.seconds >= goal_.dwell_s) {
    count_stop();  // Its verdict came after its end; or a camera sent nothing for it.
  } else {
    ++short_stops_;
    left_early_ = true;
  }
}

void CaptureMachine::on(const happened::RestOver&) {
  rest_ = Rest::none;
  if (is_under_way()) look_at_rest();
}

void CaptureMachine::on(const happened::FoundAnew&) {
  rest_ = Rest::none;
  stop_ = -1;
  stops_ = 0;
  places_in_ = 0;
  short_stops_ = 0;
  rested_s_ = 0.0;
  is_full_ = false;
  left_early_ = false;
  if (is_under_way()) look_at_rest();
}

void CaptureMachine::on(const happened::TableArrived&) {
  if (!table_is_turning_) return;
  table_is_turning_ = false;
  table_due_s_ = now_s_ + goal_.table_s;
  // The rest from before it turned is over, whether or not that was seen.
  if (is_full_) rest_ = Rest::none;
  if (is_under_way()) look_at_rest();
}

void CaptureMachine::on(const happened::TableFailed& input) {
  if (table_is_turning_) turn_again_or_fail(input.why);
}

void CaptureMachine::turn_again_or_fail(const std::string& why) {
  if (turns_told_ < most_turns_told) {
    turn();
  } else {
    fail(why);
  }
}

void CaptureMachine::on(const happened::TimePassed&) {
  if (state_ == CaptureState::checking && (are_all_there() || now_s_ - begun_s_ >= goal_.check_s)) look_at_rest();
  if (turns_told_ == 0 || now_s_ < table_due_s_) return;
  const std::string seconds = std::to_string(std::lround(goal_.table_s)) + " s";
  if (table_is_turning_)
    turn_again_or_fail("the table has not arrived within " + seconds);
  else if (state_ == CaptureState::moving)
    turn_again_or_fail("the table says that it has turned, but the rig has come to no rest elsewhere within " +
                       seconds);
}

void CaptureMachine::on(const happened::EndAsked&) {
  state_ = CaptureState::ended;
  actions_.push_back(CaptureAction::end);
}

void CaptureMachine::on(const happened::RecordingFailed& input) { fail(input.why); }

CaptureProgress CaptureMachine::progress() const {
  CaptureProgress progress;
  progress.state = state_;
  progress.stop = stop_;
  progress.stops = stops_;
  progress.wanted_stops = goal_.stops;
  progress.short_stops = short_stops_;
  progress.rested_s = rest_ == Rest::settled ? rested_s_ : 0.0;
  progress.dwell_s = goal_.dwell_s;
  progress.is_full = is_full_ && rest_ == Rest::settled;
  progress.left_early = left_early_;
  progress.turns_itself = goal_.turns_itself;
  progress.table_is_turning = table_is_turning_;
  progress.failure = failure_;
  for (const Seen& seen : sensors_) {
    if (!seen.is_there) progress.absent.push_back(seen.sensor.name);
    if (seen.is_there && seen.sensor.is_camera && !seen.has_image && state_ == CaptureState::capturing)
      progress.awaited.push_back(seen.sensor.name);
  }
  return progress;
}

}  // namespace rigcal
