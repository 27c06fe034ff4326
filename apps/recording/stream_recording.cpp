#include "apps/recording/stream_recording.h"

#include <algorithm>
#include <utility>

#include "apps/ingest/lidar_findings.h"
#include "apps/recording/cell_sink.h"
#include "apps/recording/far_points.h"
#include "apps/recording/rig_lidars.h"
#include "apps/recording/table_angles.h"

namespace rigcal {
namespace {

// Keeps the points near each LiDAR on their way to the cells.
class NearPoints final : public StopSink {
 public:
  NearPoints(StopSink& sink, std::size_t sensors, double within_m, std::vector<Patch>& out)
      : sink_(sink), within_m_(within_m), of_stop_(sensors), out_(out) {}

  Expected<void> restart() override {
    out_.clear();
    stops_ = 0;
    begin(-1);
    return sink_.restart();
  }
  [[nodiscard]] Expected<void> status() const override { return sink_.status(); }
  void points(int sensor, int stop, std::span<const Point> points) override {
    if (stop != stop_) begin(stop);
    add_near_points(points, within_m_, of_stop_[static_cast<std::size_t>(sensor)]);
    sink_.points(sensor, stop, points);
  }
  void stop_done(const StopRecord& record) override {
    if (stop_ != record.stop.index) begin(record.stop.index);
    for (std::size_t k = 0; k < of_stop_.size(); ++k) {
      if (!of_stop_[k].empty()) out_.push_back({static_cast<int>(k), stops_, std::move(of_stop_[k])});
    }
    ++stops_;
    begin(-1);
    sink_.stop_done(record);
  }

 private:
  void begin(int stop) {
    stop_ = stop;
    for (std::vector<Point>& points : of_stop_) points = {};
  }

  StopSink& sink_;
  double within_m_;
  std::vector<std::vector<Point>> of_stop_;  ///< By sensor.
  std::vector<Patch>& out_;
  int stop_ = -1;
  int stops_ = 0;
};

void take_rotations(const Rig& rig, const std::vector<StopRecord>& stops, LidarRecording& out) {
  out.R_previous_this.assign(stops.size(), std::nullopt);
  out.gyro_turns.assign(stops.size(), std::nullopt);
  out.turned_rad.assign(stops.size(), std::nullopt);
  for (std::size_t j = 1; j < stops.size(); ++j) {
    out.R_previous_this[j] = base_rotation(rig, stops[j]);
    out.gyro_turns[j] = gyro_turn(out.lidar_sensors, stops[j]);
    out.turned_rad[j] = turned_rad(stops[j]);
  }
}

}  // namespace

Expected<Recording> make_recording(const StreamSource& source, const StopReading& reading, LidarRecording lidar,
                                   const RunContext& context) {
  if (std::optional<Error> error = reading_error(source, StopOptions{}, reading)) {
    warn_of_file(source, reading, context.reporter);
    return *error;
  }
  for (const std::string& warning : reading_warnings(source, reading)) context.reporter.warn(warning);
  Recording out;
  out.rig = source.rig;
  // What stands in the place of a ring's number here is the time of the shot.
  for (Sensor& sensor : out.rig.sensors) {
    if (sensor.lidar) sensor.lidar->rings = false;
  }
  out.lidar = std::move(lidar);
  out.packets = packet_counters(out.rig, reading.ingest);
  out.clocks = clock_reports(out.rig, reading.ingest);
  for (const PatchCells& patch : out.lidar.patches) out.points += patch.points;
  for (const std::string& warning : far_point_warnings(out.rig, out.lidar)) context.reporter.warn(warning);
  if (out.points == 0) {
    std::uint64_t too_far = 0;
    for (std::size_t i = 0; i < out.lidar.lidar_sensors.size(); ++i) too_far += out.lidar.too_far_of(i);
    return no_points_error(source, reading, too_far);
  }
  take_rotations(out.rig, reading.stops, out.lidar);
  const std::vector<TableAngle> angles = session_table_angles(source.path, context.reporter);
  out.table_turns = table_turns(out.rig, angles, out.lidar.stops);
  const std::string doubt = merge_table_turns(out.table_turns, out.lidar.R_previous_this);
  if (!doubt.empty()) context.reporter.warn(doubt);
  context.reporter.debug(source.path + ": " + std::to_string(reading.stops.size()) + " stops");
  return out;
}

void tell_turns_by(const std::vector<std::optional<SE3>>& guess_T_base_sensor, Recording& recording) {
  LidarRecording& lidar = recording.lidar;
  for (std::size_t j = 0; j < std::min(lidar.gyro_turns.size(), lidar.R_previous_this.size()); ++j) {
    const std::optional<GyroTurn>& told = lidar.gyro_turns[j];
    if (!told) continue;
    const std::optional<SE3>& guess = guess_T_base_sensor[static_cast<std::size_t>(told->lidar)];
    lidar.R_previous_this[j].reset();
    if (guess) lidar.R_previous_this[j] = guess->R * told->R_previous_this * guess->R.transpose();
  }
  // Where the two disagree was told when the recording was read.
  static_cast<void>(merge_table_turns(recording.table_turns, lidar.R_previous_this));
}

Expected<Recording> read_stream(const StreamSource& source, const CellOptions& cells, double keep_points_within_m,
                                const RunContext& context) {
  LidarRecording lidar;
  lidar.lidar_sensors = lidar_sensors(source.rig);
  CellSink sink(
      source.rig, cells, [&](CalibrationStop stop) { append(std::move(stop), lidar); },
      [&] {
        lidar.patches.clear();
        lidar.too_far.clear();
        lidar.stops.clear();
      });
  std::vector<Patch> near_points;
  NearPoints near(sink, source.rig.sensors.size(), keep_points_within_m, near_points);
  const Expected<StopReading> reading = read_stops(source, StopOptions{}, near, context);
  if (!reading) return reading.error();
  Expected<Recording> recording = make_recording(source, *reading, std::move(lidar), context);
  if (recording) recording->near_points = std::move(near_points);
  return recording;
}

}  // namespace rigcal
