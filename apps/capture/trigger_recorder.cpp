#include "apps/capture/trigger_recorder.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

namespace rigcal {
namespace {

constexpr std::int64_t look_ns = 100'000'000;
constexpr std::size_t most_kept_events = 10'000;

const char* name_of(trigger::TriggerSource source) {
  switch (source) {
    case trigger::TriggerSource::output:
      return "the trigger line";
    case trigger::TriggerSource::strobe:
      return "the strobe line";
    case trigger::TriggerSource::pps:
      return "the PPS input";
  }
  return "a line";
}

}  // namespace

std::optional<trigger::TriggerOptions> trigger_options(const Rig& rig) {
  if (!rig.trigger) return std::nullopt;
  const TriggerLineSettings& lines = *rig.trigger;
  if (!lines.line && !lines.strobe_line && lines.pps.empty()) return std::nullopt;
  trigger::TriggerOptions options;
  options.is_held = true;
  const auto address = [&lines](int line) { return trigger::LineAddress{lines.gpiochip, static_cast<unsigned>(line)}; };
  if (lines.line) options.output = address(*lines.line);
  if (lines.strobe_line) options.strobe = address(*lines.strobe_line);
  options.pps = lines.pps;
  std::optional<double> rate;
  for (const Sensor& sensor : rig.sensors) {
    if (!sensor.camera || !sensor.camera->trigger || !sensor.camera->frame_rate) continue;
    rate = std::min(rate.value_or(*sensor.camera->frame_rate), *sensor.camera->frame_rate);
  }
  options.pattern.period_ns = std::llround(1e9 / rate.value_or(usual_image_rate));
  options.pattern.width_ns = std::llround(1e3 * lines.pulse_us);
  return options;
}

Expected<std::unique_ptr<TriggerRecorder>> TriggerRecorder::start(const trigger::TriggerOptions& options,
                                                                  const std::string& session,
                                                                  const net::ClockReading& session_start,
                                                                  std::vector<CameraRecorder*> cameras) {
  auto table = TriggerTable::create((std::filesystem::path(session) / "trigger.csv").string());
  if (!table) return table.error();
  auto trigger = trigger::Trigger::start(options, session_start);
  if (!trigger) return trigger.error();
  return std::unique_ptr<TriggerRecorder>(
      new TriggerRecorder(*std::move(trigger), *std::move(table), std::move(cameras)));
}

TriggerRecorder::TriggerRecorder(std::unique_ptr<trigger::Trigger> trigger, TriggerTable table,
                                 std::vector<CameraRecorder*> cameras)
    : trigger_(std::move(trigger)), table_(std::move(table)), cameras_(std::move(cameras)) {
  thread_ = std::thread([this] { take(); });
}

TriggerRecorder::~TriggerRecorder() { finish(); }

void TriggerRecorder::finish() {
  if (!thread_.joinable()) return;
  trigger_->stop();
  is_stopped_ = true;
  thread_.join();
}

void TriggerRecorder::take() {
  Expected<void> written;
  trigger::TriggerEvent event;
  while (true) {
    heartbeat_.beat();
    const bool was_stopped = is_stopped_;
    if (!trigger_->next(event, look_ns)) {
      if (was_stopped) break;
      continue;
    }
    const bool has_begun = event.kind == trigger::TriggerEventKind::pulse;
    const bool has_ended = event.kind == trigger::TriggerEventKind::end;
    if (event.source != trigger::TriggerSource::output || !(has_begun || has_ended)) {
      note(event);
      continue;
    }
    const TriggerPulse pulse{event.number, event.stamp_ns};
    for (CameraRecorder* camera : cameras_) {
      if (has_begun) {
        camera->add_pulse(pulse);
      } else {
        camera->end_pulse(pulse);
      }
    }
    if (written && has_begun) written = table_.add(pulse);
  }
  heartbeat_.rest();
  const Expected<void> closed = table_.close();
  if (written && !closed) written = closed;
  const std::lock_guard lock(mutex_);
  if (!written) failure_ = written.error();
}

void TriggerRecorder::note(const trigger::TriggerEvent& event) {
  const bool is_lost = event.kind == trigger::TriggerEventKind::lost;
  if (!is_lost && event.kind != trigger::TriggerEventKind::returned) return;
  const std::lock_guard lock(mutex_);
  if (events_.size() == most_kept_events) return;
  events_.push_back(
      {event.stamp_ns, std::string(name_of(event.source)) + (is_lost ? " is gone" : " is back"), is_lost});
}

std::vector<CaptureEvent> TriggerRecorder::take_events() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

std::vector<const Heartbeat*> TriggerRecorder::heartbeats() const {
  std::vector<const Heartbeat*> beats = trigger_->heartbeats();
  beats.push_back(&heartbeat_);
  return beats;
}

std::optional<Error> TriggerRecorder::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

}  // namespace rigcal
