#include "apps/capture.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>
#include <utility>

#include "apps/capture_log.h"
#include "apps/packet_taker.h"
#include "apps/session_counters.h"
#include "apps/trigger_recorder.h"
#include "core/base/text.h"
#include "core/base/utc_text.h"
#include "core/base/version.h"
#include "core/io/session_folder.h"

namespace rigcal {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds look_period{100};
constexpr std::chrono::seconds show_period{1};
constexpr std::int64_t pair_period_ns = 10'000'000'000;
constexpr std::int64_t pair_step_ns = 1'000;
constexpr std::size_t most_pairs = 1U << 20U;

/// Pairs of clock readings, ten a second where CLOCK_REALTIME is being set, otherwise one in ten seconds.
class ClockPairs {
 public:
  void add(const net::ClockReading& reading) {
    if (!pairs_.empty() && reading.monotonic_ns - pairs_.back().monotonic_ns < pair_period_ns) {
      const std::int64_t step =
          (reading.realtime_ns - reading.monotonic_ns) - (pairs_.back().realtime_ns - pairs_.back().monotonic_ns);
      if (std::abs(step) < pair_step_ns) return;
    }
    if (pairs_.size() < most_pairs) pairs_.push_back({reading.realtime_ns, reading.monotonic_ns});
  }
  [[nodiscard]] const std::vector<ClockPair>& pairs() const { return pairs_; }

 private:
  std::vector<ClockPair> pairs_;
};

// What the stamps of a stream say is missing.
void list_gaps(const std::string& sensor, const char* what, const StreamBook& book, std::vector<std::string>& gaps) {
  std::uint64_t listed = 0;
  for (const StreamGap& gap : book.listed_gaps) {
    gaps.push_back(utc_text(gap.start_ns) + " " + sensor + ": " + std::to_string(gap.lost) + " " + what +
                   " are missing, " + fixed_text(1e-6 * static_cast<double>(gap.length_ns), 1) + " ms");
    listed += gap.lost;
  }
  if (book.lost > listed && !book.listed_gaps.empty())
    gaps.push_back(utc_text(book.listed_gaps.back().start_ns) + " " + sensor + ": and after that " +
                   std::to_string(book.lost - listed) + " more " + what);
}

void add_matching(const MatchLedger& ledger, std::map<std::string, std::uint64_t>& counters) {
  counters.insert({{"matched", ledger.matched},
                   {"doubled", ledger.doubled},
                   {"without_pulse", ledger.without_pulse},
                   {"doubtful", ledger.doubtful + ledger.strays},
                   {"pulses_without_frame", ledger.pulses_without_frame},
                   {"pulses_too_soon", ledger.pulses_too_soon}});
}

class Capture {
 public:
  using Cameras = std::vector<std::shared_ptr<CameraRecorder>>;

  Capture(const Rig& rig, livox::Driver& driver, PacketTaker& recording, Cameras& cameras, TriggerRecorder* trigger,
          const CaptureOptions& options)
      : rig_(rig),
        driver_(driver),
        recording_(recording),
        cameras_(cameras),
        trigger_(trigger),
        options_(options),
        log_(names_of(rig)) {}

  void run(const RunContext& context, const std::function<void(const CaptureStatus&)>& show) {
    auto shown = started_;
    while (!context.cancelled() && !is_over()) {
      std::this_thread::sleep_for(look_period);
      look();
      if (recording_.has_ended()) break;
      if (Clock::now() - shown < show_period) continue;
      shown = Clock::now();
      show(status());
    }
    look();
    log_.end();
    if (trigger_ != nullptr) trigger_->finish();
    for (const auto& camera : cameras_) camera->stop();
    driver_.stop();
    recording_.finish();
    for (const auto& camera : cameras_) camera->finish();
    look();
  }

  void note_gap(const std::string& about, const std::string& what) { log_.add(now_ns(), about, what, true); }

  [[nodiscard]] CaptureStatus status() {
    const PacketTaker::Figures figures = recording_.figures();
    CaptureStatus status;
    const auto now = Clock::now();
    status.seconds = std::chrono::duration<double>(now - started_).count();
    status.bytes = figures.bytes;
    const double since = std::chrono::duration<double>(now - last_look_).count();
    std::vector<livox::DeviceReport> reports = driver_.devices();
    last_packets_.resize(reports.size(), 0);
    for (std::size_t i = 0; i < reports.size(); ++i) {
      CaptureDevice device;
      device.sensor = names_[i];
      if (since > 0.0) device.packets_per_s = static_cast<double>(reports[i].packets - last_packets_[i]) / since;
      last_packets_[i] = reports[i].packets;
      if (const DeviceIngest* heard = figures.ingest.of_sensor(rig_.find(device.sensor))) {
        device.lost = heard->point_stream.lost + heard->imu_stream.lost;
        device.expected = heard->point_stream.expected() + heard->imu_stream.expected();
        device.drift_ppm = heard->clock.drift_ppm;
      }
      device.report = std::move(reports[i]);
      status.devices.push_back(std::move(device));
    }
    last_written_.resize(cameras_.size(), 0);
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      CaptureCamera camera = cameras_[i]->status();
      if (since > 0.0) camera.frames_per_s = static_cast<double>(camera.counters.whole() - last_written_[i]) / since;
      last_written_[i] = camera.counters.whole();
      status.cameras.push_back(std::move(camera));
    }
    if (trigger_ != nullptr) status.trigger = trigger_->report();
    last_look_ = now;
    return status;
  }

  [[nodiscard]] CaptureSummary summary() {
    const PacketTaker::Figures figures = recording_.figures();
    CaptureSummary summary;
    summary.session = options_.out;
    summary.status = status();
    summary.interfaces = driver_.interfaces();
    summary.control_datagrams = driver_.control_datagrams();
    summary.recorded = figures.recorded;
    summary.dropped_control = driver_.dropped_control();
    summary.forgotten_until_ns = figures.forgotten_until_ns;
    if (figures.error) log_.add(now_ns(), "recording", figures.error->message(), true);
    summary.gaps = log_.gaps();
    for (const DeviceIngest& device : figures.ingest.devices) {
      if (device.sensor < 0) continue;
      const std::string& name = rig_.sensors[static_cast<std::size_t>(device.sensor)].name;
      list_gaps(name, "packets of points", device.point_stream, summary.gaps);
      list_gaps(name, "packets of the IMU", device.imu_stream, summary.gaps);
    }
    std::sort(summary.gaps.begin(), summary.gaps.end());  // Each begins with its time.
    summary.notes = driver_.notes();
    if (summary.status.trigger)
      summary.notes.insert(summary.notes.end(), summary.status.trigger->notes.begin(),
                           summary.status.trigger->notes.end());
    return summary;
  }

  [[nodiscard]] SessionRecord record(const CaptureSummary& summary) const {
    const PacketTaker::Figures figures = recording_.figures();
    SessionRecord record;
    record.software = version();
    record.start_ns = driver_.session_start().realtime_ns;
    record.end_ns = now_ns();
    record.clock_pairs = clock_pairs_.pairs();
    record.counters = session_counters(rig_, figures.ingest);
    for (auto& [name, counters] : record.counters) {
      counters.erase("points");  // Nobody has looked at them.
      counters.erase("imu_samples");
    }
    for (const CaptureDevice& device : summary.status.devices)
      record.counters[device.sensor]["connection_losses"] = device.report.link.counters.losses;
    for (const CaptureCamera& camera : summary.status.cameras) {
      const camera::CameraCounters& counters = camera.counters;
      record.counters[camera.sensor] = {{"frames", counters.whole()},
                                        {"images", camera.written},
                                        {"damaged", counters.damaged()},
                                        {"missing", counters.missing},
                                        {"no_buffer", counters.no_buffer},
                                        {"dropped_by_queue", camera.dropped_by_queue},
                                        {"resent_packets", counters.resent_packets},
                                        {"connection_losses", counters.losses}};
      if (camera.matching) add_matching(*camera.matching, record.counters[camera.sensor]);
    }
    if (const auto& trigger = summary.status.trigger) {
      record.counters["trigger"] = {{"pulses", trigger->pulses},
                                    {"skipped", trigger->skipped},
                                    {"strobe_pulses", trigger->strobe_pulses},
                                    {"pps_pulses", trigger->pps_pulses},
                                    {"dropped_events", trigger->dropped_events},
                                    {"connection_losses", trigger->losses}};
    }
    for (const livox::InterfaceReport& report : summary.interfaces) {
      auto& counters = record.counters["interface " + report.interface.name + " " + to_string(report.interface.ip)];
      counters = {{"received", report.counters.received},
                  {"dropped_by_kernel", report.counters.dropped_by_kernel},
                  {"dropped_by_queue", report.counters.dropped_by_queue},
                  {"strangers", report.counters.strangers},
                  {"errors", report.counters.errors}};
    }
    record.gaps = summary.gaps;
    record.events = log_.events();
    return record;
  }

  static std::vector<std::string> names_of(const Rig& rig) {
    std::vector<std::string> names;
    for (const Sensor& sensor : rig.sensors)
      if (sensor.is_lidar() && sensor.lidar->model != LidarModel::other) names.push_back(sensor.name);
    return names;
  }

 private:
  [[nodiscard]] bool is_over() const {
    return options_.duration_s &&
           std::chrono::duration<double>(Clock::now() - started_).count() >= *options_.duration_s;
  }
  [[nodiscard]] std::int64_t now_ns() const {
    return net::SessionClock(driver_.session_start()).from_monotonic(net::read_clocks().monotonic_ns);
  }
  void look() {
    clock_pairs_.add(net::read_clocks());
    for (const livox::Event& event : driver_.control().take_events()) log_.add(event);
    log_.compare(now_ns(), driver_.interfaces());
    for (const auto& camera : cameras_) {
      for (const CaptureEvent& event : camera->take_events())
        log_.add(event.stamp_ns, camera->status().sensor, event.text, event.is_gap);
    }
    if (trigger_ == nullptr) return;
    for (const CaptureEvent& event : trigger_->take_events())
      log_.add(event.stamp_ns, "trigger", event.text, event.is_gap);
  }

  const Rig& rig_;
  livox::Driver& driver_;
  PacketTaker& recording_;
  Cameras& cameras_;
  TriggerRecorder* trigger_;  ///< Nothing where the rig has no lines.
  const CaptureOptions& options_;
  std::vector<std::string> names_ = names_of(rig_);
  CaptureLog log_;
  ClockPairs clock_pairs_;
  Clock::time_point started_ = Clock::now();
  Clock::time_point last_look_ = started_;
  std::vector<std::uint64_t> last_packets_;
  std::vector<std::uint64_t> last_written_;  ///< Frames, by camera.
};

}  // namespace

bool CaptureSummary::is_complete() const {
  const bool all_there = std::all_of(status.devices.begin(), status.devices.end(), [](const CaptureDevice& device) {
    return device.report.packets > 0 && device.report.link.counters.losses == 0;
  });
  const bool all_kept = std::all_of(interfaces.begin(), interfaces.end(), [](const livox::InterfaceReport& report) {
    return report.counters.dropped_by_kernel == 0 && report.counters.dropped_by_queue == 0;
  });
  const bool all_seen = std::all_of(status.cameras.begin(), status.cameras.end(), [](const CaptureCamera& camera) {
    return camera.written > 0 && camera.dropped_by_queue == 0 && camera.counters.no_buffer == 0 &&
           camera.counters.losses == 0;
  });
  return all_there && all_kept && all_seen;
}

Expected<CaptureSummary> capture(const Rig& rig, const livox::DriverOptions& driver_options,
                                 const CaptureOptions& options, const RunContext& context,
                                 const std::function<void(const CaptureStatus&)>& show) {
  std::error_code error;
  if (std::filesystem::exists(options.out, error))  // Before a LiDAR is taken.
    return input_error("exists already, and a session is never overwritten", options.out, "choose another name");
  auto driver = livox::Driver::start(driver_options);
  if (!driver) return driver.error();
  SessionRecord begun;
  begun.software = version();
  begun.start_ns = (*driver)->session_start().realtime_ns;
  if (const auto created = create_session(options.out, rig, begun); !created) return created.error();
  auto recorder = PacketRecorder::create(options.out, options.keep_bytes);
  if (!recorder) return recorder.error();
  PacketTaker recording(**driver, *std::move(recorder), rig);
  for (const std::string& note : (*driver)->notes()) context.reporter.warn(note);
  CameraDrivers camera_drivers(camera_settings_folder());
  Capture::Cameras cameras;
  for (const RigCamera& wanted : rig_cameras(rig)) {
    auto camera = CameraRecorder::start(wanted, camera_drivers, options.out, (*driver)->session_start());
    if (!camera) return camera.error();
    cameras.push_back(*std::move(camera));
  }
  std::unique_ptr<TriggerRecorder> trigger;
  std::string no_trigger;
  if (const auto lines = trigger_options(rig)) {
    std::vector<CameraRecorder*> told;
    for (const auto& camera : cameras) told.push_back(camera.get());
    auto started = TriggerRecorder::start(*lines, options.out, (*driver)->session_start(), std::move(told));
    if (!started && started.error().kind != ErrorKind::system) return started.error();
    if (started) {
      trigger = *std::move(started);
    } else {
      no_trigger = started.error().message();  // The LiDARs, and cameras that run free, are worth recording.
      context.reporter.warn(no_trigger);
    }
  }
  Capture running(rig, **driver, recording, cameras, trigger.get(), options);
  if (!no_trigger.empty()) running.note_gap("trigger", no_trigger);
  running.run(context, show);
  const CaptureSummary summary = running.summary();
  const Expected<void> recorded = write_session_record(options.out, running.record(summary));
  if (const auto failure = recording.figures().error) return *failure;
  for (const auto& camera : cameras) {
    if (const auto failure = camera->failure()) return *failure;
  }
  if (trigger) {
    if (const auto failure = trigger->failure()) return *failure;
  }
  if (!recorded) return recorded.error();
  return summary;
}

}  // namespace rigcal
