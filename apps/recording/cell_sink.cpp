#include "apps/recording/cell_sink.h"

#include <utility>

#include "apps/recording/rig_lidars.h"
#include "core/base/parallel.h"

namespace rigcal {

CellSink::CellSink(const Rig& rig, const CellOptions& options, Taker taker, std::function<void()> restarted)
    : rig_(rig),
      options_(options),
      taker_(std::move(taker)),
      restarted_(std::move(restarted)),
      lidar_of_sensor_(rig.sensors.size(), -1) {
  const std::vector<int> lidars = lidar_sensors(rig);
  for (std::size_t i = 0; i < lidars.size(); ++i) {
    lidar_of_sensor_[static_cast<std::size_t>(lidars[i])] = static_cast<int>(i);
  }
  pending_.resize(lidars.size());
}

Expected<void> CellSink::restart() {
  stops_ = 0;
  stop_ = -1;
  if (restarted_) restarted_();
  return {};
}

void CellSink::points(int sensor, int stop, std::span<const Point> points) {
  const int lidar = lidar_of_sensor_[static_cast<std::size_t>(sensor)];
  if (stop != stop_) begin(stop);
  auto& pending = pending_[static_cast<std::size_t>(lidar)];
  pending.insert(pending.end(), points.begin(), points.end());
  waiting_ += points.size();
  if (waiting_ > 400'000) sum_up();
}

void CellSink::stop_done(const StopRecord& record) {
  if (stop_ != record.stop.index) begin(record.stop.index);
  sum_up();
  std::vector<PatchCells> patches(builders_.size());
  parallel_for(builders_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) patches[i] = builders_[i].finish();
  });
  CalibrationStop stop;
  stop.stop = record.stop;
  if (stops_ > 0) {
    stop.R_previous_this = base_rotation(rig_, record);
    stop.gyro_turn = gyro_turn(lidar_sensors(rig_), record);
    stop.turned_rad = turned_rad(record);
  }
  for (PatchCells& patch : patches) {
    stop.too_far.push_back(patch.too_far);
    if (patch.points > 0) stop.patches.push_back(std::move(patch));
  }
  ++stops_;
  stop_ = -1;
  taker_(std::move(stop));
}

void CellSink::begin(int stop) {
  stop_ = stop;
  builders_.resize(pending_.size());
  for (std::size_t i = 0; i < pending_.size(); ++i) {
    builders_[i].begin(static_cast<int>(i), stop, options_);
    pending_[i].clear();
  }
  waiting_ = 0;
}

void CellSink::sum_up() {
  parallel_for(builders_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      builders_[i].add(pending_[i]);
      pending_[i].clear();
    }
  });
  waiting_ = 0;
}

}  // namespace rigcal
