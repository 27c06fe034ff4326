#include "apps/recording/stop_pass.h"

#include <algorithm>
#include <utility>

namespace rigcal {
namespace {

bool has_imu(const Sensor& sensor) {
  if (!sensor.is_lidar() || sensor.lidar->imu == false) return false;
  return !sensor.lidar->imu_topic.empty() || facts_of(sensor.lidar->model).has_imu;
}

/// Notes the stops on their way to the sink.
class NotingSink final : public PatchSink {
 public:
  NotingSink(PatchSink& sink, std::vector<StopRecord>& stops, PassWatcher* watcher)
      : sink_(sink), stops_(stops), watcher_(watcher) {}
  void points(int sensor, int stop, std::span<const Point> points) override { sink_.points(sensor, stop, points); }
  void timed_points(int sensor, int stop, const ShotTimes& times, std::span<const Point> part) override {
    sink_.timed_points(sensor, stop, times, part);
  }
  void stop_done(const StopRecord& stop) override {
    stops_.push_back(stop);
    sink_.stop_done(stop);
    if (watcher_ != nullptr) watcher_->found(stop);
  }

 private:
  PatchSink& sink_;
  std::vector<StopRecord>& stops_;
  PassWatcher* watcher_;
};

// Rough extrinsics are good enough: a few degrees of the axis do not matter to what shows a turn.
std::map<int, Vector3d> turn_axes(const Rig& rig) {
  std::map<int, Vector3d> axes;
  const Vector3d axis = rig.turntable && rig.turntable->axis ? *rig.turntable->axis : Vector3d(Vector3d::UnitZ());
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    const bool is_base = static_cast<int>(i) == rig.base;
    const std::optional<SE3>& guess = rig.sensors[i].initial_T_base_sensor;
    if (is_base) {
      axes[static_cast<int>(i)] = axis;
    } else if (guess) {
      axes[static_cast<int>(i)] = guess->R.transpose() * axis;
    }
  }
  return axes;
}

}  // namespace

PassPlan first_plan(const Rig& rig, const StopOptions& options) {
  PassPlan plan{options, {}};
  plan.options.turn_axes = turn_axes(rig);
  if (rig.sensors.empty()) return plan;
  if (plan.options.imu_sensor < 0 && has_imu(rig.base_sensor())) plan.options.imu_sensor = rig.base;
  if (std::none_of(rig.sensors.begin(), rig.sensors.end(), has_imu)) plan.options.source = StopSource::points;
  return plan;
}

Expected<StopPass> read_pass(const BatchOpener& open, const std::string& name, const PassPlan& plan, StopSink& sink,
                             const RunContext& context, PassWatcher* watcher) {
  StopPass pass;
  if (const Expected<void> ready = sink.restart(); !ready) return ready.error();
  NotingSink noting(sink, pass.reading.stops, watcher);
  StopFinder finder(plan.options, noting);
  const BatchSinks sinks{[&](PointBatch& batch) {
                           finder.add_points(batch);
                           if (watcher != nullptr) watcher->looked(finder, batch.stamp_ns);
                         },
                         [&](const ImuSample& sample) {
                           finder.add_imu(sample);
                           if (watcher != nullptr) watcher->looked(finder, sample.stamp_ns);
                         },
                         [&](const RecordedImage& image) { sink.image(image); }};
  const Expected<std::unique_ptr<BatchSource>> batches = open(sinks, plan.codes);
  if (!batches) return batches.error();
  while (true) {
    const Expected<bool> more = (*batches)->read_some();
    if (!more) return more.error();
    if (!*more) break;
    if (const Expected<void> status = sink.status(); !status) return status.error();
    if (context.cancelled()) return cancelled_error("stopped", name);
    if (watcher != nullptr && !watcher->goes_on(**batches, finder)) return pass;
    context.reporter.progress("reading", (*batches)->fraction());
  }
  if (context.cancelled()) return cancelled_error("stopped", name);
  finder.flush();
  if (const Expected<void> status = sink.status(); !status) return status.error();
  pass.reading.ingest = (*batches)->summary();
  pass.reading.source = plan.options.source;
  pass.reading.gyro = finder.gyro_figures();
  pass.reading.view = finder.point_figures();
  pass.reading.points = finder.point_counts();
  pass.reading.truncation = (*batches)->truncation();
  pass.reading.notes = (*batches)->notes();
  pass.better_codes = (*batches)->better_codes();
  return pass;
}

}  // namespace rigcal
