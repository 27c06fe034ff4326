#include "apps/stream_recording.h"

#include "apps/lidar_findings.h"
#include "apps/stop_reader.h"
#include "apps/table_angles.h"
#include "core/base/parallel.h"

namespace rigcal {
namespace {

// Points of the stops into cells, several sensors at once: each has its own builder and gets its points in order.
class CellSink final : public StopSink {
 public:
  CellSink(const Rig& rig, const CellOptions& options, double keep_within_m, Recording& out)
      : lidar_of_sensor_(rig.sensors.size(), -1),
        options_(options),
        keep_within_m_(keep_within_m),
        out_(out.lidar),
        near_(out.near_points) {
    for (std::size_t k = 0; k < rig.sensors.size(); ++k) {
      if (!rig.sensors[k].is_lidar()) continue;
      lidar_of_sensor_[k] = static_cast<int>(out_.lidar_sensors.size());
      out_.lidar_sensors.push_back(static_cast<int>(k));
    }
    pending_.resize(out_.lidar_sensors.size());
  }

  Expected<void> restart() override {
    out_.patches.clear();
    out_.stops.clear();
    near_.clear();
    points_ = 0;
    stop_ = -1;
    return {};
  }

  [[nodiscard]] Expected<void> status() const override { return {}; }

  void points(int sensor, int stop, std::span<const Point> points) override {
    const int lidar = lidar_of_sensor_[static_cast<std::size_t>(sensor)];
    if (stop != stop_) begin(stop);
    add_near_points(points, keep_within_m_, near_of_stop_[static_cast<std::size_t>(lidar)]);
    auto& pending = pending_[static_cast<std::size_t>(lidar)];
    pending.insert(pending.end(), points.begin(), points.end());
    waiting_ += points.size();
    if (waiting_ > 400'000) sum_up();
  }

  void stop_done(const StopRecord& record) override {
    if (stop_ != record.stop.index) begin(record.stop.index);
    sum_up();
    std::vector<PatchCells> patches(builders_.size());
    parallel_for(builders_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) patches[i] = builders_[i].finish();
    });
    for (PatchCells& patch : patches) {
      patch.stop = static_cast<int>(out_.stops.size());
      points_ += patch.points;
      if (patch.points > 0) out_.patches.push_back(std::move(patch));
    }
    for (std::size_t i = 0; i < near_of_stop_.size(); ++i) {
      if (near_of_stop_[i].empty()) continue;
      near_.push_back({out_.lidar_sensors[i], static_cast<int>(out_.stops.size()), std::move(near_of_stop_[i])});
    }
    out_.stops.push_back(record.stop);
    stop_ = -1;
  }

  [[nodiscard]] std::uint64_t points() const { return points_; }

 private:
  void begin(int stop) {
    stop_ = stop;
    near_of_stop_.assign(pending_.size(), {});
    builders_.clear();
    for (std::size_t i = 0; i < pending_.size(); ++i) {
      builders_.emplace_back(static_cast<int>(i), stop, options_);
      pending_[i].clear();
    }
    waiting_ = 0;
  }

  void sum_up() {
    parallel_for(builders_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        builders_[i].add(pending_[i]);
        pending_[i].clear();
      }
    });
    waiting_ = 0;
  }

  std::vector<int> lidar_of_sensor_;
  CellOptions options_;
  double keep_within_m_;
  LidarRecording& out_;
  std::vector<Patch>& near_;
  std::vector<std::vector<Point>> near_of_stop_;  ///< By LiDAR.
  int stop_ = -1;
  std::vector<CellBuilder> builders_;
  std::vector<std::vector<Point>> pending_;
  std::size_t waiting_ = 0;
  std::uint64_t points_ = 0;
};

void take_rotations(const Rig& rig, const std::vector<StopRecord>& stops, LidarRecording& out) {
  out.R_previous_this.resize(stops.size());
  out.turned_rad.resize(stops.size());
  for (std::size_t j = 1; j < stops.size(); ++j) {
    out.R_previous_this[j] = base_rotation(rig, stops[j]);
    if (stops[j].rotation_known) out.turned_rad[j] = log_so3(stops[j].R_previous_this).norm();
  }
}

}  // namespace

Expected<Recording> read_stream(const StreamSource& source, const CellOptions& cells, double keep_points_within_m,
                                const RunContext& context) {
  Recording out;
  out.rig = source.rig;
  CellSink sink(out.rig, cells, keep_points_within_m, out);
  const StopOptions options;
  const Expected<StopReading> reading = read_stops(source, options, sink, context);
  if (!reading) return reading.error();
  if (std::optional<Error> error = reading_error(source, options, *reading)) return *error;
  for (const std::string& warning : reading_warnings(source, *reading)) context.reporter.warn(warning);
  out.packets = packet_counters(out.rig, reading->ingest);
  out.clocks = clock_reports(out.rig, reading->ingest);
  out.points = sink.points();
  if (out.points == 0) {
    return input_error("no points while the rig stood still", source.path, "check that sampling was on");
  }
  take_rotations(out.rig, reading->stops, out.lidar);
  const auto angles = session_table_angles(source.path);
  if (!angles) return angles.error();
  const std::string doubt =
      merge_table_turns(table_turns(out.rig, *angles, out.lidar.stops), out.lidar.R_previous_this);
  if (!doubt.empty()) context.reporter.warn(doubt);
  context.reporter.debug(source.path + ": " + std::to_string(reading->stops.size()) + " stops");
  return out;
}

}  // namespace rigcal
