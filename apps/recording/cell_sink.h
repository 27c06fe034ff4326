#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "apps/recording/stop_reader.h"
#include "core/pipeline/incremental_calibration.h"

namespace rigcal {

/// The points of the stops on their way into cells, several sensors at once: each has its own builder and gets its
/// points in order.
class CellSink final : public StopSink {
 public:
  /// What becomes of a stop; without a point in no LiDAR it has no patch.
  using Taker = std::function<void(CalibrationStop)>;

  /// `rig` must outlive this. `restarted` is called when all stops so far are to be forgotten; may be empty.
  CellSink(const Rig& rig, const CellOptions& options, Taker taker, std::function<void()> restarted);

  Expected<void> restart() override;
  [[nodiscard]] Expected<void> status() const override { return {}; }
  void points(int sensor, int stop, std::span<const Point> points) override;
  void stop_done(const StopRecord& record) override;

 private:
  void begin(int stop);
  void sum_up();

  const Rig& rig_;
  CellOptions options_;
  Taker taker_;
  std::function<void()> restarted_;
  std::vector<int> lidar_of_sensor_;
  int stops_ = 0;
  int stop_ = -1;
  std::vector<CellBuilder> builders_;
  std::vector<std::vector<Point>> pending_;
  std::size_t waiting_ = 0;
};

}  // namespace rigcal
