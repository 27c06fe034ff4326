#include "apps/capture/capture.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <thread>
#include <utility>

#include "apps/capture/capture_guide.h"
#include "apps/capture/capture_log.h"
#include "apps/capture/capture_rates.h"
#include "apps/capture/capture_record.h"
#include "apps/capture/disk_watch.h"
#include "apps/capture/session_keeper.h"
#include "apps/capture/table_recorder.h"
#include "apps/capture/thread_watch.h"
#include "apps/capture/trigger_recorder.h"
#include "apps/recording/recorded_formats.h"
#include "core/base/seconds.h"
#include "core/base/version.h"
#include "core/io/session_folder.h"

namespace rigcal {
namespace {

constexpr std::chrono::milliseconds look_period{100};
constexpr std::chrono::milliseconds show_period{500};
constexpr std::chrono::seconds disk_period{1};
constexpr std::chrono::seconds secure_period{10};  // Where no stop comes meanwhile.
constexpr std::chrono::seconds longest_last_sync{20};
constexpr std::size_t shown_events = 20;

// Of cameras that were left at a format which the rig file does not name, by their number in the rig.
std::map<int, std::string> misread_formats(const Rig& rig,
                                           const std::vector<std::shared_ptr<CameraRecorder>>& cameras) {
  std::map<int, std::string> formats;
  for (const auto& camera : cameras) {
    const CaptureCamera status = camera->status();
    const int sensor = rig.find(status.sensor);
    const std::string& told = rig.sensors[static_cast<std::size_t>(sensor)].camera->pixel_format;
    if (status.written > 0 && is_misread(status.pixel_format, told)) formats[sensor] = status.pixel_format;
  }
  return formats;
}

std::vector<std::string> names_of_lidars(const Rig& rig) {
  std::vector<std::string> names;
  for (const Sensor& sensor : rig.sensors)
    if (sensor.is_livox()) names.push_back(sensor.name);
  return names;
}

/// What takes part in a capture. Members are ended in the order of `Capture::shut_down`.
struct Parts {
  livox::Driver& driver;
  PacketTaker& recording;
  std::vector<std::shared_ptr<CameraRecorder>>& cameras;
  TriggerRecorder* trigger;  ///< Nothing where the rig has no lines.
  TableRecorder* table;      ///< Nothing where it is turned by hand.
  LiveStops& stops;
  SessionKeeper& keeper;

  [[nodiscard]] std::vector<std::string> camera_names() const {
    std::vector<std::string> names;
    for (const auto& camera : cameras) names.push_back(camera->status().sensor);
    return names;
  }
  [[nodiscard]] std::vector<const Heartbeat*> heartbeats() const {
    std::vector<const Heartbeat*> beats{&recording.heartbeat(), &keeper.heartbeat()};
    for (const auto& camera : cameras) beats.insert(beats.end(), {&camera->taking(), &camera->writing()});
    for (const Heartbeat* beat : driver.heartbeats()) beats.push_back(beat);
    if (trigger != nullptr) {
      for (const Heartbeat* beat : trigger->heartbeats()) beats.push_back(beat);
    }
    if (table != nullptr) beats.push_back(&table->heartbeat());
    beats.push_back(&stops.heartbeat());
    return beats;
  }
};

class Capture {
 public:
  Capture(const Rig& rig, const Parts& parts, const CaptureOptions& options)
      : rig_(rig),
        parts_(parts),
        options_(options),
        names_(names_of_lidars(rig)),
        guide_(options.goal, names_, parts.camera_names(), parts.stops, parts.table),
        log_(names_),
        disk_(options.out),
        threads_(parts_.heartbeats()) {}

  void run(const RunContext& context, const std::function<void(const CaptureStatus&)>& show) {
    auto shown = started_;
    while (true) {
      std::this_thread::sleep_for(look_period);
      look();
      const bool is_enough = options_.is_enough && options_.is_enough();
      if (context.cancelled() || is_over() || is_enough) guide_.end(now_ns());
      if (parts_.recording.has_ended()) {
        const auto error = parts_.recording.figures().error;
        end_unwritten(context.reporter, error ? error->message() : "the recording has ended");
      }
      look_at_disk(context.reporter);
      watch();
      const CaptureGuide::Wish wish = guide_.look(now_ns(), parts_.driver.devices(), cameras());
      take_guide_events();
      if (parts_.trigger != nullptr) parts_.trigger->hold(!guide_.wants_images());
      for (const auto& camera : parts_.cameras) camera->want_images(guide_.wants_images());
      if (wish.end) break;
      if (wish.secure || SteadyClock::now() - secured_ >= secure_period) secure();
      if (SteadyClock::now() - shown < show_period) continue;
      shown = SteadyClock::now();
      CaptureStatus now = status();
      rates_.add(now, shown);
      show(now);
    }
    shut_down(context);
  }

  void note_gap(const std::string& about, const std::string& what) { log_.add(now_ns(), about, what, true); }

  [[nodiscard]] CaptureStatus status() {
    const PacketTaker::Figures figures = parts_.recording.figures();
    CaptureStatus status;
    status.seconds = seconds_since(started_);
    status.bytes = figures.bytes;
    std::vector<livox::DeviceReport> reports = parts_.driver.devices();
    for (std::size_t i = 0; i < reports.size(); ++i) {
      CaptureDevice device;
      device.sensor = names_[i];
      if (const DeviceIngest* heard = figures.ingest.of_sensor(rig_.find(device.sensor))) {
        device.lost = heard->point_stream.lost + heard->imu_stream.lost;
        device.expected = heard->point_stream.expected() + heard->imu_stream.expected();
        device.drift_ppm = heard->clock.drift_ppm;
      }
      device.report = std::move(reports[i]);
      status.devices.push_back(std::move(device));
    }
    status.cameras = cameras();
    if (parts_.trigger != nullptr) status.trigger = parts_.trigger->report();
    status.progress = guide_.progress();
    status.stops = guide_.stops();
    status.live = parts_.stops.status();
    if (parts_.table != nullptr) status.table_deg = parts_.table->angle_deg();
    status.disk = disk_.room();
    status.worst_wait_s = seconds_of_ns(figures.worst_wait_ns);
    status.worst_write_s = seconds_of_ns(figures.worst_write_ns);
    status.stuck_threads = threads_.stuck();
    status.events = log_.count();
    status.news = log_.last_events(shown_events);
    return status;
  }

  [[nodiscard]] CaptureSummary summary() {
    const PacketTaker::Figures figures = parts_.recording.figures();
    CaptureSummary summary;
    summary.session = options_.out;
    summary.status = status();
    summary.interfaces = parts_.driver.interfaces();
    summary.control_datagrams = parts_.driver.control_datagrams();
    summary.recorded = figures.recorded;
    summary.dropped_control = parts_.driver.dropped_control();
    summary.control = parts_.driver.control().counters();
    summary.forgotten_until_ns = figures.forgotten_until_ns;
    summary.start_ns = parts_.driver.session_start().realtime_ns;
    summary.end_ns = end_ns_;
    if (figures.error) log_.add(now_ns(), "recording", figures.error->message(), true);
    summary.gaps = log_.gaps();
    const std::vector<std::string> gaps = stream_gaps(rig_, figures.ingest);
    summary.gaps.insert(summary.gaps.end(), gaps.begin(), gaps.end());
    for (const Shortfall& shortfall : summary.shortfalls())
      if (!shortfall.gap.empty()) summary.gaps.push_back(shortfall.gap);
    std::sort(summary.gaps.begin(), summary.gaps.end());  // Each begins with its time.
    summary.notes = parts_.driver.notes();
    if (summary.status.trigger)
      summary.notes.insert(summary.notes.end(), summary.status.trigger->notes.begin(),
                           summary.status.trigger->notes.end());
    if (reading_) {
      summary.status.stops.clear();
      for (const StopRecord& stop : reading_->stops) summary.status.stops.push_back(stop.stop);
    }
    summary.reading = std::move(reading_);
    summary.closing_s = closing_s_;
    return summary;
  }

  [[nodiscard]] SessionRecord record(const CaptureStatus& status, std::vector<std::string> gaps) const {
    SessionRecord record;
    record.software = version();
    record.start_ns = parts_.driver.session_start().realtime_ns;
    record.clock_pairs = clock_pairs_.pairs();
    record.counters = capture_counters(rig_, parts_.recording.figures(), status, parts_.driver.interfaces());
    threads_.count(record.counters);
    const livox::DatagramRing& control = parts_.driver.control().ring();
    record.counters["control"] = control_counters(parts_.driver.control().counters());
    record.counters["control"].merge(NamedCounters{{"most_waiting", control.high_water()},
                                                   {"queue", control.capacity()},
                                                   {"dropped_by_queue", control.dropped()}});
    record.counters["stops"] = {{"worst_behind_us", static_cast<std::uint64_t>(worst_behind_ns_ / 1000)}};
    if (parts_.table != nullptr) record.counters["turntable"] = {{"most_waiting", parts_.table->most_waiting()}};
    record.counters["recording"]["secured"] = parts_.keeper.secured();
    record.counters["recording"]["worst_secure_us"] = static_cast<std::uint64_t>(1e6 * parts_.keeper.worst_s());
    record.gaps = std::move(gaps);
    record.events = log_.events();
    return record;
  }
  [[nodiscard]] SessionRecord last_record(const CaptureSummary& summary) const {
    SessionRecord last = record(summary.status, summary.gaps);
    last.end_ns = now_ns();
    return last;
  }

  /// The disk ran out of room; what was there is recorded.
  [[nodiscard]] const std::optional<Error>& disk_failure() const { return disk_.full(); }

 private:
  [[nodiscard]] bool is_over() const { return options_.duration_s && seconds_since(started_) >= *options_.duration_s; }
  [[nodiscard]] std::int64_t now_ns() const {
    return net::SessionClock(parts_.driver.session_start()).from_monotonic(monotonic_now_ns());
  }
  [[nodiscard]] std::vector<CaptureCamera> cameras() const {
    std::vector<CaptureCamera> cameras;
    for (const auto& camera : parts_.cameras) cameras.push_back(camera->status());
    return cameras;
  }

  void look() {
    clock_pairs_.add(net::read_clocks());
    for (const livox::Event& event : parts_.driver.control().take_events()) log_.add(event);
    log_.compare(now_ns(), parts_.driver.interfaces());
    log_.compare(now_ns(), parts_.driver.devices());
    for (const auto& camera : parts_.cameras) {
      for (const CaptureEvent& event : camera->take_events())
        log_.add(event.stamp_ns, camera->status().sensor, event.text, event.is_gap);
    }
    if (parts_.trigger == nullptr) return;
    for (const CaptureEvent& event : parts_.trigger->take_events())
      log_.add(event.stamp_ns, "trigger", event.text, event.is_gap);
  }
  void take_guide_events() {
    for (const CaptureEvent& event : guide_.take_events())
      log_.add(event.stamp_ns, "capture", event.text, event.is_gap);
  }

  // The error itself is told when it has ended.
  void end_unwritten(Reporter& reporter, const std::string& why) {
    if (!std::exchange(is_unwritten_, true)) reporter.warn("the session cannot be written any more: the capture ends");
    guide_.end(now_ns(), why);
  }

  void look_at_disk(Reporter& reporter) {
    if (SteadyClock::now() - disk_looked_ < disk_period) return;
    disk_looked_ = SteadyClock::now();
    if (const auto failure = parts_.keeper.failure()) {
      end_unwritten(reporter, failure->message());
      return;
    }
    if (const auto loss = parts_.keeper.loss(); loss && !std::exchange(is_loss_told_, true)) {
      log_.add(now_ns(), "recording", loss->message(), true);
      reporter.warn(loss->message());
    }
    const auto free = free_bytes(options_.out);
    if (!free) {  // The folder may be gone: whether it is shows when it is written to.
      secure();
      return;
    }
    std::uint64_t bytes = parts_.recording.figures().bytes;
    for (const CaptureCamera& camera : cameras()) bytes += camera.bytes;
    if (const auto warning = disk_.look(seconds_since(started_), bytes, *free)) {
      log_.add(now_ns(), "recording", *warning, false);
      reporter.warn(*warning);
    }
    if (disk_.full()) guide_.end(now_ns(), disk_.full()->message());
  }

  // Threads that do not move any more, and how far the search for stops is behind the packets.
  void watch() {
    for (const ThreadWatch::News& news : threads_.look()) log_.add(now_ns(), "thread " + news.thread, news.text, false);
    const std::int64_t read_ns = parts_.stops.status().read_until_ns;
    for (const livox::DeviceReport& device : parts_.driver.devices())
      if (read_ns != 0) worst_behind_ns_ = std::max(worst_behind_ns_, device.last_packet_ns - read_ns);
  }

  void secure() {
    secured_ = SteadyClock::now();
    parts_.keeper.secure(record(status(), log_.gaps()));
  }

  // No more pulses, then no more frames, then no more packets; then what is on its way is written; then the stops are
  // read to the end.
  void shut_down(const RunContext& context) {
    const auto begun = SteadyClock::now();
    end_ns_ = now_ns();
    look();
    log_.end();
    if (parts_.trigger != nullptr) parts_.trigger->finish();
    for (const auto& camera : parts_.cameras) camera->stop();
    parts_.driver.stop();
    parts_.recording.finish();
    for (const auto& camera : parts_.cameras) camera->finish();
    parts_.keeper.stop_writing();
    // Not to be cut short: that it was told to stop is a normal end.
    Expected<StopReading> reading = parts_.stops.finish({context.reporter, {}});
    if (reading) {
      reading_ = std::move(*reading);
    } else {
      log_.add(now_ns(), "stops", reading.error().message(), false);
    }
    guide_.look(now_ns(), parts_.driver.devices(), cameras());
    take_guide_events();
    look();
    closing_s_ = seconds_since(begun);
  }

  const Rig& rig_;
  Parts parts_;
  const CaptureOptions& options_;
  std::vector<std::string> names_;
  CaptureGuide guide_;
  CaptureLog log_;
  ClockPairs clock_pairs_;
  SteadyClock::time_point started_ = SteadyClock::now();
  CaptureRates rates_{started_};
  SteadyClock::time_point secured_ = started_;
  SteadyClock::time_point disk_looked_;  ///< Long ago at first.
  DiskWatch disk_;
  bool is_unwritten_ = false;  ///< And so it was told.
  bool is_loss_told_ = false;
  ThreadWatch threads_;
  std::int64_t end_ns_ = 0;
  double closing_s_ = 0.0;
  std::int64_t worst_behind_ns_ = 0;
  std::optional<StopReading> reading_;
};

}  // namespace

Expected<CaptureSummary> capture(const Rig& rig, const livox::DriverOptions& driver_options,
                                 const CaptureOptions& options, const RunContext& context,
                                 const std::function<void(const CaptureStatus&)>& show) {
  std::error_code error;
  if (std::filesystem::exists(options.out, error))  // Before a LiDAR is taken.
    return input_error("exists already, and a session is never overwritten", options.out, "choose another name");
  auto driver = livox::Driver::start(driver_options);
  if (!driver) return driver.error();
  std::unique_ptr<turntable::Table> turns;  // Before a session is made.
  if (const auto wanted = table_options(rig)) {
    auto started = turntable::Table::start(*wanted, (*driver)->session_start());
    if (!started) return started.error();
    turns = *std::move(started);
  }
  SessionRecord begun;
  begun.software = version();
  begun.start_ns = (*driver)->session_start().realtime_ns;
  if (const auto created = create_session(options.out, rig, begun); !created) return created.error();
  auto recorder = PacketRecorder::create(options.out, options.keep_bytes);
  if (!recorder) return recorder.error();
  std::unique_ptr<TableRecorder> table;
  if (turns) {
    auto made = TableRecorder::create(std::move(turns), options.out);
    if (!made) return made.error();
    table = *std::move(made);
  }
  PacketTaker recording(**driver, *std::move(recorder), rig);
  for (const std::string& note : (*driver)->notes()) context.reporter.warn(note);
  CameraDrivers camera_drivers(camera_settings_folder());
  std::vector<std::shared_ptr<CameraRecorder>> cameras;
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
  NoPoints no_sink;
  StreamSource source;
  source.path = options.out;
  source.file = session_packets_path(options.out);
  source.rig = rig;
  LiveStops stops(std::move(source), recording.progress(), options.sink != nullptr ? *options.sink : no_sink);
  SessionKeeper keeper(options.out);
  CaptureOptions wanted = options;
  wanted.goal.turns_itself = table != nullptr;
  Capture running(rig, {**driver, recording, cameras, trigger.get(), table.get(), stops, keeper}, wanted);
  if (!no_trigger.empty()) running.note_gap("trigger", no_trigger);
  running.run(context, show);
  CaptureSummary summary = running.summary();
  const Expected<void> recorded = write_session_record(options.out, running.last_record(summary));
  const Expected<void> named = name_formats(options.out, rig, misread_formats(rig, cameras), context.reporter);
  const bool is_on_disk = keeper.finish(longest_last_sync);
  if (const auto& failure = running.disk_failure()) return *failure;
  if (const auto failure = recording.figures().error) return *failure;
  if (const auto failure = keeper.failure()) return *failure;
  if (const auto loss = keeper.loss()) return *loss;
  if (!is_on_disk)
    context.reporter.warn("the disk still writes what was recorded: leave it connected until it rests (sync)");
  if (table && table->failure()) return *table->failure();
  if (trigger) {
    if (const auto failure = trigger->failure()) return *failure;
  }
  if (!recorded) return recorded.error();
  if (!named) return named.error();
  return summary;
}

}  // namespace rigcal
