#pragma once

#include <optional>

#include "core/stops/creep_guard.h"
#include "core/stops/patch_cutter.h"
#include "core/stops/point_still_detector.h"
#include "core/stops/still_detector.h"

namespace rigcal {

/// Stops from one sensor's inertial unit or from the points alone (`StopOptions::source`), and the points of all
/// sensors cut into patches. With a unit the points are watched too, for creep that hides in the gyro's bias
/// (CreepGuard). Feed it in order of arrival, live or from a file: the outcome depends on that order alone. Not for
/// several threads at once.
///
///   StopFinder finder(StopOptions{}, sink);
///   finder.add_imu(sample); finder.add_points(batch); ... finder.flush();
class StopFinder {
 public:
  StopFinder(const StopOptions& options, PatchSink& sink)
      : cutter_(options.max_held_points, sink),
        guard_(options, cutter_),
        points_(options, options.source == StopSource::gyro ? guard_.points() : cutter_) {
    if (options.source == StopSource::gyro) gyro_.emplace(options, guard_);
  }
  StopFinder(const StopFinder&) = delete;
  StopFinder& operator=(const StopFinder&) = delete;
  ~StopFinder() = default;

  void add_imu(const ImuSample& sample) {
    if (gyro_) gyro_->add(sample);
  }
  /// Points of any sensor, session time; up to half a second behind the inertial unit or ahead of it.
  void add_points(const PointBatch& batch) {
    cutter_.add(batch);
    points_.add(batch);
  }
  /// The end of the stream: closes the last stop, which the sink is told. To be called once.
  void flush() {
    points_.flush();
    if (gyro_) gyro_->flush();
    cutter_.flush();
  }

  /// Of the gyro; empty where the points alone are asked.
  [[nodiscard]] StillFigures gyro_figures() const { return gyro_ ? gyro_->figures() : StillFigures{}; }
  /// The rest that goes on now, about 0.75 s late by the gyro, up to 2 s by the points; creep does not end it here.
  [[nodiscard]] std::optional<RestNow> rest() const { return gyro_ ? gyro_->rest() : points_.rest(); }
  [[nodiscard]] PointStillFigures point_figures() const { return points_.figures(); }
  [[nodiscard]] const PointCounts& point_counts() const { return cutter_.counts(); }

 private:
  PatchCutter cutter_;
  CreepGuard guard_;
  PointStillDetector points_;
  std::optional<StillDetector> gyro_;
};

}  // namespace rigcal
