#include "apps/capture/live_stops.h"

#include <sys/resource.h>
#include <unistd.h>

#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "apps/capture/growing_datagrams.h"

namespace rigcal {
namespace {

constexpr int background_niceness = 10;
constexpr std::int64_t silence_ns = 5'000'000'000;  // So long a unit that is waited for may keep silent.
constexpr std::int64_t status_period_ns = 50'000'000;
constexpr std::size_t most_events = 10'000;

std::uint64_t imu_samples(const IngestSummary& ingest, int sensor) {
  std::uint64_t samples = 0;
  for (const DeviceIngest& device : ingest.devices) {
    if (device.sensor >= 0 && (sensor < 0 || device.sensor == sensor)) samples += device.imu_samples;
  }
  return samples;
}

// Whether `read_stops` would read the finished session with this plan in the end.
bool is_plan_of_the_whole(const Rig& rig, const PassPlan& plan, const StopPass& pass) {
  if (pass.better_codes) return false;
  // A file is given more memory.
  if (pass.reading.points.dropped[static_cast<std::size_t>(DropReason::overflow)] > 0) return false;
  StopOptions whole = first_plan(rig, {}).options;
  const IngestSummary& ingest = pass.reading.ingest;
  const bool is_anybody_turning = imu_samples(ingest, -1) > 0;
  if (plan.options.source == StopSource::points) return whole.source == StopSource::points || !is_anybody_turning;
  if (whole.imu_sensor >= 0 && is_anybody_turning && imu_samples(ingest, whole.imu_sensor) == 0) whole.imu_sensor = -1;
  return plan.options.imu_sensor == whole.imu_sensor && !pass.reading.stops.empty();
}

}  // namespace

/// The reading thread and what it tells.
class LiveStops::Reading final : public StopSink, public PassWatcher {
 public:
  Reading(StreamSource source, std::shared_ptr<RecordingProgress> progress, StopSink& sink)
      : source_(std::move(source)), progress_(std::move(progress)), sink_(sink), plan_(first_plan(source_.rig, {})) {
    thread_ = std::thread([this] { run(); });
  }
  ~Reading() override {
    stop_.request_stop();
    if (thread_.joinable()) thread_.join();
  }
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;

  std::vector<LiveStopEvent> take_events() {
    const std::lock_guard lock(mutex_);
    return std::exchange(events_, {});
  }
  const Heartbeat& heartbeat() const { return heartbeat_; }
  LiveStopStatus figures() const {
    const std::lock_guard lock(mutex_);
    return status_;
  }
  Expected<StopReading> finish(const RunContext& context) {
    {
      const std::stop_callback stop(context.stop, [this] { stop_.request_stop(); });
      thread_.join();
    }
    if (!pass_) return pass_.error();
    if (is_plan_of_the_whole(source_.rig, plan_, *pass_)) return std::move(pass_->reading);
    context.reporter.debug("the stops are found anew, with what the end of the recording told");
    tell({LiveStopEvent::Kind::anew, 0, -1, {}});
    Expected<StopReading> reading = read_stops(source_, StopOptions{}, *this, context);
    if (reading) {
      for (const StopRecord& stop : reading->stops) found(stop);
    }
    return reading;
  }

 private:
  Expected<void> restart() override {
    rest_.reset();
    points_.clear();
    return sink_.restart();
  }
  [[nodiscard]] Expected<void> status() const override { return sink_.status(); }
  void points(int sensor, int stop, std::span<const Point> points) override {
    points_[sensor] += points.size();
    sink_.points(sensor, stop, points);
  }
  void timed_points(int sensor, int stop, const ShotTimes& times, std::span<const Point> part) override {
    points_[sensor] += part.size();
    sink_.timed_points(sensor, stop, times, part);
  }
  void stop_done(const StopRecord& stop) override {
    points_.clear();
    sink_.stop_done(stop);
  }

  void looked(const StopFinder& finder, std::int64_t stamp_ns) override {
    heartbeat_.beat();
    if (first_ns_ == 0) first_ns_ = stamp_ns;
    const std::optional<RestNow> rest = finder.rest();
    const bool goes_on = rest && rest_ && rest->since_ns <= rest_->until_ns;
    if (rest_ && !goes_on) {
      tell({LiveStopEvent::Kind::moving, rest_->until_ns, -1, {}});
      rest_.reset();
    }
    if (rest && !rest_) tell({LiveStopEvent::Kind::still, rest->since_ns, -1, {}});
    if (rest && rest->stop >= 0 && (!rest_ || rest_->stop < 0))
      tell({LiveStopEvent::Kind::settled, rest->settled_ns, rest->stop, {}});
    const bool is_news = rest.has_value() != rest_.has_value();
    rest_ = rest;
    if (!is_news && stamp_ns < told_ns_ + status_period_ns && stamp_ns >= told_ns_) return;
    told_ns_ = stamp_ns;
    const std::lock_guard lock(mutex_);
    status_.read_until_ns = stamp_ns;
    status_.rest = rest;
    status_.points_in_rest = points_;
  }
  void found(const StopRecord& stop) override {
    tell({LiveStopEvent::Kind::complete, stop.stop.end_ns, stop.stop.index, stop});
    const std::lock_guard lock(mutex_);
    status_.stops = stop.stop.index + 1;
    status_.points_in_rest.clear();
  }
  // What a reading of the whole would find out at its end is guessed as soon as it shows.
  bool goes_on(const BatchSource& batches, const StopFinder& finder) override {
    PassPlan better = plan_;
    if (const auto codes = batches.better_codes()) {
      better.codes = *codes;
    } else if (plan_.options.source == StopSource::gyro && told_ns_ - first_ns_ > silence_ns &&
               finder.gyro_figures().imu_samples == 0) {
      if (finder.gyro_figures().imu_of_others > 0) {
        better.options.imu_sensor = -1;
      } else {
        better.options.source = StopSource::points;
      }
    } else {
      return true;
    }
    better_plan_ = std::move(better);
    return false;
  }

  void run() {
    // Whoever receives and records comes first. Where it is refused, the system is busy for other reasons.
    static_cast<void>(::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), background_niceness));
    SilentReporter silent;
    const BatchOpener open = [this](BatchSinks sinks,
                                    const BroadcastCodes& codes) -> Expected<std::unique_ptr<BatchSource>> {
      return make_batches(std::make_unique<GrowingDatagrams>(progress_, stop_.get_token(), &heartbeat_), source_.rig,
                          std::move(sinks), codes);
    };
    while (true) {
      first_ns_ = 0;
      told_ns_ = 0;
      pass_ = read_pass(open, source_.path, plan_, *this, {silent, stop_.get_token()}, this);
      if (!pass_ || !better_plan_) break;
      plan_ = *std::exchange(better_plan_, std::nullopt);
      tell({LiveStopEvent::Kind::anew, 0, -1, {}});
    }
    heartbeat_.rest();
    const std::lock_guard lock(mutex_);
    if (!pass_) status_.failure = pass_.error();
  }

  void tell(LiveStopEvent event) {
    const std::lock_guard lock(mutex_);
    if (event.kind == LiveStopEvent::Kind::anew) {
      events_.clear();
      status_ = {};
    }
    if (events_.size() < most_events) events_.push_back(std::move(event));
  }

  StreamSource source_;
  std::shared_ptr<RecordingProgress> progress_;
  StopSink& sink_;
  std::stop_source stop_;
  Heartbeat heartbeat_{"finding stops"};
  PassPlan plan_;                        ///< This and what follows: of the reading thread.
  std::optional<PassPlan> better_plan_;  ///< To read again with.
  std::optional<RestNow> rest_;          ///< As told last.
  std::map<int, std::uint64_t> points_;
  std::int64_t first_ns_ = 0;
  std::int64_t told_ns_ = 0;
  Expected<StopPass> pass_ = StopPass{};

  mutable std::mutex mutex_;  ///< Of what follows.
  std::vector<LiveStopEvent> events_;
  LiveStopStatus status_;
  std::thread thread_;
};

LiveStops::LiveStops(StreamSource source, std::shared_ptr<RecordingProgress> progress, StopSink& sink)
    : reading_(std::make_unique<Reading>(std::move(source), std::move(progress), sink)) {}
LiveStops::~LiveStops() = default;

std::vector<LiveStopEvent> LiveStops::take_events() { return reading_->take_events(); }
LiveStopStatus LiveStops::status() const { return reading_->figures(); }
const Heartbeat& LiveStops::heartbeat() const { return reading_->heartbeat(); }
Expected<StopReading> LiveStops::finish(const RunContext& context) { return reading_->finish(context); }

}  // namespace rigcal
