#include "apps/capture/capture_guide.h"

#include <array>
#include <cstdio>
#include <utility>

#include "core/base/seconds.h"
#include "core/turntable/coach.h"

namespace rigcal {
namespace {

using Kind = LiveStopEvent::Kind;
using TableKind = turntable::TableNews::Kind;

constexpr std::int64_t most_behind_ns = 3'000'000'000;  // What was read longer ago is not what the rig does now.
constexpr std::size_t most_events = 10'000;

std::vector<CaptureSensor> sensors_of(const std::vector<std::string>& lidars, const std::vector<std::string>& cameras) {
  std::vector<CaptureSensor> sensors;
  for (const std::string& name : lidars) sensors.push_back({name, false});
  for (const std::string& name : cameras) sensors.push_back({name, true});
  return sensors;
}

std::string stop_text(const StopRecord& record) {
  const char* end = record.end == StopEnd::stream ? "the end of the recording" : to_string(record.end);
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "stop %d is over, %.1f s, ended by %s", record.stop.index,
                seconds_of_ns(record.stop.end_ns - record.stop.start_ns), end);
  return text.data();
}

// How many are in is said along with the number that the session's files have, which is another one.
std::string counts_text(int stop, const CaptureProgress& progress) {
  std::string text = "stop " + std::to_string(stop) + " counts: " + std::to_string(progress.stops);
  if (progress.wanted_stops > 0) text += " of " + std::to_string(progress.wanted_stops);
  return text + ((progress.wanted_stops > 0 ? progress.wanted_stops : progress.stops) == 1 ? " stop in" : " stops in");
}

}  // namespace

CaptureGuide::CaptureGuide(const CaptureGoal& goal, const std::vector<std::string>& lidars,
                           const std::vector<std::string>& cameras, LiveStops& stops, TableRecorder* table)
    : machine_(goal, sensors_of(lidars, cameras)), stops_(stops), table_(table), lidars_(lidars.size()) {
  for (const CaptureSensor& sensor : sensors_of(lidars, cameras)) names_.push_back(sensor.name);
  is_there_.assign(names_.size(), false);
  last_image_ns_.assign(cameras.size(), 0);
}

void CaptureGuide::say(std::string text, bool is_gap) { say_at(now_ns_, std::move(text), is_gap); }

void CaptureGuide::say_at(std::int64_t stamp_ns, std::string text, bool is_gap) {
  if (events_.size() < most_events) events_.push_back({stamp_ns, std::move(text), is_gap});
}

void CaptureGuide::tell(const CaptureInput& input) {
  const std::vector<CaptureAction> actions = machine_.handle(seconds_of_ns(now_ns_), input);
  const CaptureProgress progress = machine_.progress();
  if (progress.stops > full_stops_) say(counts_text(stop_, progress));
  full_stops_ = progress.stops;
  for (const CaptureAction action : actions) {
    switch (action) {
      case CaptureAction::turn_table:
        if (table_ != nullptr) table_->turn_by(step_deg(progress));
        say("the table is told to turn");
        break;
      case CaptureAction::secure:
        wish_.secure = true;
        break;
      case CaptureAction::end:
        wish_.end = true;
        break;
    }
  }
  if (progress.state == std::exchange(told_state_, progress.state)) return;
  const bool is_failed = progress.state == CaptureState::failed;
  say(is_failed ? "failed: " + progress.failure : std::string(to_string(progress.state)), is_failed);
}

void CaptureGuide::look_at_sensors(const std::vector<livox::DeviceReport>& lidars,
                                   const std::vector<CaptureCamera>& cameras) {
  for (std::size_t i = 0; i < names_.size(); ++i) {
    bool is_there = false;
    if (i < lidars_) {
      // One whose packets are kept out by a firewall answers, too.
      is_there = i < lidars.size() && lidars[i].link.state == livox::LinkState::sampling && lidars[i].packets > 0;
    } else if (i - lidars_ < cameras.size()) {
      const std::string& state = cameras[i - lidars_].state;
      is_there = state == "sends" || state == "waits";
    }
    if (is_there == is_there_[i]) continue;
    is_there_[i] = is_there;
    const int sensor = static_cast<int>(i);
    tell(is_there ? CaptureInput(happened::SensorCame{sensor}) : CaptureInput(happened::SensorWent{sensor}));
  }
}

void CaptureGuide::look_at_stops(const std::vector<CaptureCamera>& cameras) {
  for (const LiveStopEvent& event : stops_.take_events()) {
    switch (event.kind) {
      case Kind::still:
        tell(happened::RestBegan{});
        break;
      case Kind::settled:
        settled_ns_ = event.stamp_ns;
        stop_ = event.stop;
        tell(happened::RestSettled{event.stop, seconds_of_ns(event.stamp_ns)});
        break;
      case Kind::complete: {
        const Stop& stop = event.record->stop;
        found_.push_back(stop);
        tell(happened::StopOver{stop.index, seconds_of_ns(stop.end_ns - stop.start_ns)});
        settled_ns_.reset();
        say_at(stop.end_ns, stop_text(*event.record), false);  // It was found some time after.
        break;
      }
      case Kind::moving:
        settled_ns_.reset();
        tell(happened::RestOver{});
        break;
      case Kind::anew:
        settled_ns_.reset();
        found_.clear();
        full_stops_ = 0;
        tell(happened::FoundAnew{});
        say("the stops are found anew, with what was learned about the devices");
        break;
    }
  }
  const LiveStopStatus status = stops_.status();
  if (!settled_ns_ || !status.rest || status.rest->stop < 0 || now_ns_ - status.read_until_ns > most_behind_ns) return;
  for (std::size_t i = 0; i < last_image_ns_.size() && i < cameras.size(); ++i) {
    const std::int64_t image_ns = cameras[i].last_image_ns;
    if (image_ns <= last_image_ns_[i] || image_ns < *settled_ns_) continue;
    last_image_ns_[i] = image_ns;
    tell(happened::ImageCame{static_cast<int>(lidars_ + i)});
  }
  tell(happened::Rested{seconds_of_ns(status.rest->until_ns - *settled_ns_)});
}

bool CaptureGuide::wants_images() const {
  const CaptureProgress progress = machine_.progress();
  if (progress.state == CaptureState::capturing && !progress.is_full) return true;
  const LiveStopStatus status = stops_.status();
  return status.failure || (status.read_until_ns != 0 && now_ns_ - status.read_until_ns > most_behind_ns);
}

void CaptureGuide::look_at_table() {
  if (table_ == nullptr) return;
  for (const turntable::TableEvent& event : table_->take_events()) {
    if (event.kind == TableKind::arrived) tell(happened::TableArrived{});
    if (event.kind != TableKind::failed) continue;
    say("the table failed: " + event.text, true);
    tell(happened::TableFailed{event.text});
  }
}

CaptureGuide::Wish CaptureGuide::look(std::int64_t now_ns, const std::vector<livox::DeviceReport>& lidars,
                                      const std::vector<CaptureCamera>& cameras) {
  now_ns_ = now_ns;
  if (machine_.state() == CaptureState::idle) tell(happened::Begun{});
  look_at_sensors(lidars, cameras);
  look_at_stops(cameras);
  look_at_table();
  tell(happened::TimePassed{});
  return std::exchange(wish_, {});
}

void CaptureGuide::end(std::int64_t now_ns, const std::string& failure) {
  now_ns_ = now_ns;
  tell(failure.empty() ? CaptureInput(happened::EndAsked{}) : CaptureInput(happened::RecordingFailed{failure}));
}

}  // namespace rigcal
