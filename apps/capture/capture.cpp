#include "apps/capture/capture.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <thread>
#include <utility>

#include "apps/capture/capture_guide.h"
#include "apps/capture/capture_log.h"
#include "apps/capture/capture_parts.h"
#include "apps/capture/capture_rates.h"
#include "apps/capture/capture_record.h"
#include "apps/capture/disk_watch.h"
#include "apps/capture/doctor.h"
#include "apps/capture/thread_watch.h"
#include "apps/recording/recorded_formats.h"
#include "core/base/seconds.h"
#include "core/base/text.h"
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
constexpr double rivals_after_s = 5.0;  // A LiDAR without a host broadcasts every second.

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

CaptureGoal goal_of(const CaptureOptions& options, const CaptureParts& parts) {
  CaptureGoal goal = options.goal;
  goal.turns_itself = parts.table != nullptr;
  return goal;
}

/// A capture from when all of its parts are started.
class Capture {
 public:
  /// All must outlive it.
  Capture(const Rig& rig, CaptureParts& parts, const CaptureOptions& options);

  /// Until it is to end.
  void run(const RunContext& context, const std::function<void(const CaptureStatus&)>& show);
  /// Ends what records, and reads the stops to the end.
  void shut_down(const RunContext& context);
  /// Writes down what came of it. Errors: what kept any of it from being written.
  [[nodiscard]] Expected<CaptureSummary> finish(Reporter& reporter);

 private:
  // What it knows now.
  [[nodiscard]] std::int64_t now_ns() const;
  [[nodiscard]] std::vector<CaptureDevice> lidars(const IngestSummary& ingest) const;
  [[nodiscard]] std::vector<CaptureCamera> cameras() const;
  [[nodiscard]] CaptureStatus status() const;
  [[nodiscard]] SessionRecord record(const CaptureStatus& status, std::vector<std::string> gaps) const;

  // While it runs.
  void take_events();
  void take_guide_events();
  [[nodiscard]] bool is_over() const;
  void look_at_recording(Reporter& reporter);
  void look_at_disk(Reporter& reporter);
  void end_unwritten(Reporter& reporter, const std::string& why);
  void watch(Reporter& reporter);
  void look_for_rivals(Reporter& reporter);
  void take_unread(const Error& error);
  CaptureGuide::Wish guide();
  void secure();

  // In the end.
  [[nodiscard]] DiskPatience patience(Reporter& reporter) const;
  [[nodiscard]] std::vector<std::string> all_gaps(const CaptureSummary& summary, const IngestSummary& ingest) const;
  [[nodiscard]] CaptureSummary summarize();

  const Rig& rig_;
  CaptureParts& parts_;
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
  bool has_looked_for_rivals_ = false;
  ThreadWatch threads_;
  std::int64_t end_ns_ = 0;
  double closing_s_ = 0.0;
  std::int64_t worst_behind_ns_ = 0;
  std::optional<StopReading> reading_;
  std::optional<Error> unread_;  ///< Why the stops were not found to the end.
};

Capture::Capture(const Rig& rig, CaptureParts& parts, const CaptureOptions& options)
    : rig_(rig),
      parts_(parts),
      options_(options),
      names_(names_of_lidars(rig)),
      guide_(goal_of(options, parts), names_, parts.camera_names(), *parts.stops, parts.table.get()),
      log_(names_),
      disk_(options.out, options.keep_bytes),
      threads_(parts.heartbeats()) {
  if (!parts.no_trigger.empty()) log_.add(now_ns(), "trigger", parts.no_trigger, true);
}

void Capture::run(const RunContext& context, const std::function<void(const CaptureStatus&)>& show) {
  auto shown = started_;
  while (true) {
    std::this_thread::sleep_for(look_period);
    take_events();
    const bool is_enough = options_.is_enough && options_.is_enough();
    if (context.cancelled() || is_over() || is_enough) guide_.end(now_ns());
    look_at_recording(context.reporter);
    look_at_disk(context.reporter);
    watch(context.reporter);
    look_for_rivals(context.reporter);
    const CaptureGuide::Wish wish = guide();
    if (wish.end) return;
    if (wish.secure || SteadyClock::now() - secured_ >= secure_period) secure();
    if (SteadyClock::now() - shown < show_period) continue;
    shown = SteadyClock::now();
    CaptureStatus now = status();
    rates_.add(now, shown);
    show(now);
  }
}

void Capture::shut_down(const RunContext& context) {
  const auto begun = SteadyClock::now();
  end_ns_ = now_ns();
  take_events();
  log_.end();
  parts_.finish_recording(patience(context.reporter));
  // Not to be cut short: that it was told to stop is a normal end.
  Expected<StopReading> reading = parts_.stops->finish({context.reporter, {}});
  if (reading) {
    reading_ = std::move(*reading);
  } else if (!unread_) {
    take_unread(reading.error());
  }
  guide_.look(now_ns(), parts_.driver->devices(), cameras());
  take_guide_events();
  take_events();
  closing_s_ = seconds_since(begun);
}

Expected<CaptureSummary> Capture::finish(Reporter& reporter) {
  CaptureSummary summary = summarize();
  SessionRecord last = record(summary.status, summary.gaps);
  last.end_ns = now_ns();
  const auto write_last = [&]() -> Expected<void> {
    const DiskPatience bounded = patience(reporter);
    const DiskWait wait(bounded, "session.json", nullptr);
    const Expected<void> recorded = write_session_record(options_.out, last);
    const Expected<void> named = name_formats(options_.out, rig_, misread_formats(rig_, parts_.cameras), reporter);
    return recorded ? named : recorded;
  };
  const Expected<void> written = write_last();
  const bool is_on_disk = parts_.keeper->finish(longest_last_sync);
  if (const auto& failure = disk_.full()) return *failure;  // What was there is recorded.
  if (const auto failure = parts_.recording->figures().error) return *failure;
  if (const auto failure = parts_.keeper->failure()) return *failure;
  if (const auto loss = parts_.keeper->loss()) return *loss;
  if (!is_on_disk) reporter.warn("the disk still writes what was recorded: leave it connected until it rests (sync)");
  if (parts_.table && parts_.table->failure()) return *parts_.table->failure();
  if (parts_.trigger) {
    if (const auto failure = parts_.trigger->failure()) return *failure;
  }
  if (!written) return written.error();
  return summary;
}

std::int64_t Capture::now_ns() const {
  return net::SessionClock(parts_.driver->session_start()).from_monotonic(monotonic_now_ns());
}

std::vector<CaptureDevice> Capture::lidars(const IngestSummary& ingest) const {
  std::vector<CaptureDevice> lidars;
  std::vector<livox::DeviceReport> reports = parts_.driver->devices();
  for (std::size_t i = 0; i < reports.size(); ++i) {
    CaptureDevice& device = lidars.emplace_back();
    device.sensor = names_[i];
    if (const DeviceIngest* heard = ingest.of_sensor(rig_.find(device.sensor))) {
      device.lost = heard->point_stream.lost + heard->imu_stream.lost;
      device.expected = heard->point_stream.expected() + heard->imu_stream.expected();
      device.drift_ppm = heard->clock.drift_ppm;
    }
    device.report = std::move(reports[i]);
  }
  return lidars;
}

std::vector<CaptureCamera> Capture::cameras() const {
  std::vector<CaptureCamera> cameras;
  for (const auto& camera : parts_.cameras) cameras.push_back(camera->status());
  return cameras;
}

CaptureStatus Capture::status() const {
  const PacketTaker::Figures figures = parts_.recording->figures();
  CaptureStatus status;
  status.seconds = seconds_since(started_);
  status.bytes = figures.bytes;
  status.devices = lidars(figures.ingest);
  status.cameras = cameras();
  if (parts_.trigger) status.trigger = parts_.trigger->report();
  status.progress = guide_.progress();
  status.stops = guide_.stops();
  status.live = parts_.stops->status();
  if (parts_.table) status.table_deg = parts_.table->angle_deg();
  status.disk = disk_.room();
  status.worst_wait_s = seconds_of_ns(figures.worst_wait_ns);
  status.worst_write_s = seconds_of_ns(figures.worst_write_ns);
  status.stuck_threads = threads_.stuck();
  status.events = log_.count();
  status.news = log_.last_events(shown_events);
  return status;
}

SessionRecord Capture::record(const CaptureStatus& status, std::vector<std::string> gaps) const {
  SessionRecord record;
  record.software = version();
  record.start_ns = parts_.driver->session_start().realtime_ns;
  record.clock_pairs = clock_pairs_.pairs();
  record.counters = capture_counters(rig_, parts_.recording->figures(), status, parts_.driver->interfaces());
  threads_.count(record.counters);
  const livox::DatagramRing& control = parts_.driver->control().ring();
  record.counters["control"] = control_counters(parts_.driver->control().counters());
  record.counters["control"].merge(NamedCounters{
      {"most_waiting", control.high_water()}, {"queue", control.capacity()}, {"dropped_by_queue", control.dropped()}});
  record.counters["stops"] = {{"worst_behind_us", static_cast<std::uint64_t>(worst_behind_ns_ / 1000)}};
  if (parts_.table) record.counters["turntable"] = {{"most_waiting", parts_.table->most_waiting()}};
  record.counters["recording"]["secured"] = parts_.keeper->secured();
  record.counters["recording"]["worst_secure_us"] = static_cast<std::uint64_t>(1e6 * parts_.keeper->worst_s());
  record.gaps = std::move(gaps);
  record.events = log_.events();
  return record;
}

void Capture::take_events() {
  clock_pairs_.add(net::read_clocks());
  for (const livox::Event& event : parts_.driver->control().take_events()) log_.add(event);
  log_.compare(now_ns(), parts_.driver->interfaces());
  log_.compare(now_ns(), parts_.driver->devices());
  for (const auto& camera : parts_.cameras) {
    for (const CaptureEvent& event : camera->take_events())
      log_.add(event.stamp_ns, camera->status().sensor, event.text, event.is_gap);
  }
  if (!parts_.trigger) return;
  for (const CaptureEvent& event : parts_.trigger->take_events())
    log_.add(event.stamp_ns, "trigger", event.text, event.is_gap);
}

void Capture::take_guide_events() {
  for (const CaptureEvent& event : guide_.take_events()) log_.add(event.stamp_ns, "capture", event.text, event.is_gap);
}

bool Capture::is_over() const { return options_.duration_s && seconds_since(started_) >= *options_.duration_s; }

void Capture::look_at_recording(Reporter& reporter) {
  if (!parts_.recording->has_ended()) return;
  const auto error = parts_.recording->figures().error;
  end_unwritten(reporter, error ? error->message() : "the recording has ended");
}

void Capture::look_at_disk(Reporter& reporter) {
  if (SteadyClock::now() - disk_looked_ < disk_period) return;
  disk_looked_ = SteadyClock::now();
  if (const auto failure = parts_.keeper->failure()) {
    end_unwritten(reporter, failure->message());
    return;
  }
  if (const auto loss = parts_.keeper->loss(); loss && !std::exchange(is_loss_told_, true)) {
    log_.add(now_ns(), "recording", loss->message(), true);
    reporter.warn(loss->message());
  }
  const auto free = free_bytes(options_.out);
  if (!free) {  // The folder may be gone: whether it is shows when it is written to.
    secure();
    return;
  }
  SessionBytes bytes{parts_.recording->figures().bytes, 0};
  for (const CaptureCamera& camera : cameras()) bytes.images += camera.bytes;
  if (const auto warning = disk_.look(seconds_since(started_), bytes, *free)) {
    log_.add(now_ns(), "recording", *warning, false);
    reporter.warn(*warning);
  }
  if (disk_.full()) guide_.end(now_ns(), disk_.full()->message());
}

// The error itself is told when it has ended.
void Capture::end_unwritten(Reporter& reporter, const std::string& why) {
  if (!std::exchange(is_unwritten_, true)) reporter.warn("the session cannot be written any more: the capture ends");
  guide_.end(now_ns(), why);
}

// Threads that do not move any more, and how far the search for stops is behind the packets.
void Capture::watch(Reporter& reporter) {
  for (const ThreadWatch::News& news : threads_.look()) log_.add(now_ns(), "thread " + news.thread, news.text, false);
  const LiveStopStatus stops = parts_.stops->status();
  if (stops.failure && !unread_) {
    take_unread(*stops.failure);
    reporter.warn("no more stops are found, the recording goes on: " + unread_->message());
  }
  const std::int64_t read_ns = stops.read_until_ns;
  for (const livox::DeviceReport& device : parts_.driver->devices())
    if (read_ns != 0) worst_behind_ns_ = std::max(worst_behind_ns_, device.last_packet_ns - read_ns);
}

// A LiDAR that another program has says nothing to anybody else.
void Capture::look_for_rivals(Reporter& reporter) {
  if (has_looked_for_rivals_ || seconds_since(started_) < rivals_after_s) return;
  has_looked_for_rivals_ = true;
  std::vector<std::string> unheard;
  const std::vector<livox::DeviceReport> devices = parts_.driver->devices();
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (devices[i].link.counters.handshakes == 0) unheard.push_back(names_[i]);
  }
  if (unheard.empty()) return;
  const std::uint16_t port = livox::kDiscoveryPort;
  const std::string rivals = rivals_text(net::port_holders(port), ::getpid(), port);
  if (rivals.empty()) return;
  const std::string text = "no broadcast of " + joined(unheard, ", ") + " was heard yet, and " + rivals;
  log_.add(now_ns(), "discovery", text, false);
  reporter.warn(text);
}

void Capture::take_unread(const Error& error) {
  unread_ = error;
  log_.add(now_ns(), "stops", error.message(), false);
}

// Lets it decide, and does what it wants of those that can be told when to take images.
CaptureGuide::Wish Capture::guide() {
  const CaptureGuide::Wish wish = guide_.look(now_ns(), parts_.driver->devices(), cameras());
  take_guide_events();
  if (parts_.trigger) parts_.trigger->hold(!guide_.wants_images());
  for (const auto& camera : parts_.cameras) camera->want_images(guide_.wants_images());
  return wish;
}

void Capture::secure() {
  secured_ = SteadyClock::now();
  parts_.keeper->secure(record(status(), log_.gaps()));
}

DiskPatience Capture::patience(Reporter& reporter) const {
  DiskPatience patience;
  patience.tell = [&reporter](const std::string& what) {
    reporter.warn("the capture has ended, but the disk does not take " + what +
                  ": it is waited for (a second Ctrl-C ends at once, and loses that)");
  };
  if (!options_.give_up) return patience;
  patience.give_up = [this](std::chrono::nanoseconds waited) {
    options_.give_up(options_.out + ": the disk has taken nothing for " +
                     std::to_string(std::chrono::duration_cast<std::chrono::seconds>(waited).count()) +
                     " s: ended without it; what it has is finished by rigcal inspect --repair, once it answers");
  };
  return patience;
}

std::vector<std::string> Capture::all_gaps(const CaptureSummary& summary, const IngestSummary& ingest) const {
  std::vector<std::string> gaps = log_.gaps();
  for (std::string& gap : stream_gaps(rig_, ingest)) gaps.push_back(std::move(gap));
  for (const Shortfall& shortfall : summary.shortfalls())
    if (!shortfall.gap.empty()) gaps.push_back(shortfall.gap);
  std::sort(gaps.begin(), gaps.end());  // Each begins with its time.
  return gaps;
}

CaptureSummary Capture::summarize() {
  const PacketTaker::Figures figures = parts_.recording->figures();
  CaptureSummary summary;
  summary.session = options_.out;
  summary.status = status();
  summary.interfaces = parts_.driver->interfaces();
  summary.control_datagrams = parts_.driver->control_datagrams();
  summary.recorded = figures.recorded;
  summary.dropped_control = parts_.driver->dropped_control();
  summary.control = parts_.driver->control().counters();
  summary.forgotten_until_ns = figures.forgotten_until_ns;
  summary.start_ns = parts_.driver->session_start().realtime_ns;
  summary.end_ns = end_ns_;
  if (figures.error) log_.add(now_ns(), "recording", figures.error->message(), true);
  summary.gaps = all_gaps(summary, figures.ingest);
  summary.notes = parts_.driver->notes();
  if (summary.status.trigger)
    summary.notes.insert(summary.notes.end(), summary.status.trigger->notes.begin(),
                         summary.status.trigger->notes.end());
  if (reading_) {
    summary.status.stops.clear();
    for (const StopRecord& stop : reading_->stops) summary.status.stops.push_back(stop.stop);
  }
  summary.reading = std::move(reading_);
  summary.status.live.failure = unread_;
  summary.closing_s = closing_s_;
  return summary;
}

}  // namespace

Expected<CaptureSummary> capture(const Rig& rig, const livox::DriverOptions& driver, const CaptureOptions& options,
                                 const RunContext& context, const std::function<void(const CaptureStatus&)>& show) {
  Expected<CaptureParts> parts = CaptureParts::start(rig, driver, options, context.reporter);
  if (!parts) return parts.error();
  Capture running(rig, *parts, options);
  running.run(context, show);
  running.shut_down(context);
  return running.finish(context.reporter);
}

}  // namespace rigcal
