#pragma once

#include "core/stops/patch_cutter.h"

namespace rigcal {

/// Stops from one sensor's inertial unit, and the points of all sensors cut into patches. Feed it in order of arrival,
/// live or from a file: the outcome depends on that order alone. Not for several threads at once.
///
///   StopFinder finder(StopOptions{}, sink);
///   finder.add_imu(sample); finder.add_points(batch); ... finder.flush();
///
/// A rig without an inertial unit: drive a PatchCutter from another StillListener source instead.
class StopFinder {
 public:
  StopFinder(const StopOptions& options, PatchSink& sink)
      : cutter_(options.max_held_points, sink), detector_(options, cutter_) {}
  StopFinder(const StopFinder&) = delete;
  StopFinder& operator=(const StopFinder&) = delete;
  ~StopFinder() = default;

  void add_imu(const ImuSample& sample) { detector_.add(sample); }
  /// Points of any sensor, session time; up to half a second behind the inertial unit or ahead of it.
  void add_points(const PointBatch& batch) { cutter_.add(batch); }
  /// The end of the stream: closes the last stop, which the sink is told. To be called once.
  void flush() {
    detector_.flush();
    cutter_.flush();
  }

  [[nodiscard]] StillFigures figures() const { return detector_.figures(); }
  [[nodiscard]] const PointCounts& point_counts() const { return cutter_.counts(); }

 private:
  PatchCutter cutter_;
  StillDetector detector_;
};

}  // namespace rigcal
