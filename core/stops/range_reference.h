#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/se3.h"

namespace rigcal {

/// A return by its direction: a cube's face (the axis of the largest component and its sign), cut into cells, the
/// tangents of the two components that follow that axis in cyclic order, and the depth along it.
struct RangePoint {
  std::int32_t cell = -1;  ///< -1: no direction or no sensible distance.
  float u = 0.0F;
  float v = 0.0F;
  float depth = 0.0F;  ///< m
};
[[nodiscard]] RangePoint to_range_point(float x, float y, float z);
/// The same point in another frame.
[[nodiscard]] RangePoint transformed(const SE3& T, const RangePoint& point);

/// What some points say of the sensor's motion since a reference was taken, to first order: the normal equations of the
/// distances of the points from the reference's planes. Those of several pieces of time add up.
struct RangeMotion {
  Matrix6d information = Matrix6d::Zero();  ///< Of xi = [rotation rad; translation m], T_reference_now = exp(xi).
  Vector6d right = Vector6d::Zero();        ///< information * xi = right.
  double met = 0.0;                         ///< Points in directions that the reference knows,
  double inside = 0.0;                      ///< and those of them within three sigma of its planes.
  double points = 0.0;

  void operator+=(const RangeMotion& other);
};

/// The surfaces that a LiDAR sees around it, as a sparse panorama: for each direction of about three degrees the plane
/// through the returns there. Along a plane n^T p = D the inverse depth 1/x is linear in y/x and z/x, so that one
/// linear fit a direction, without iterations, gives plane and noise. Directions that show no plane (edges, foliage,
/// walking people) are left out. To sum up quickly, all points of a cell count as in its middle. Nothing is assumed
/// about the scan pattern but that it comes back to a direction.
class RangeReference {
 public:
  RangeReference();

  /// Starts anew. `pieces`: points of times in which the sensor stood still.
  void build(std::span<const std::span<const RangePoint>> pieces);
  /// People and whatever else moves in a part of the view weigh little: a point's weight falls with its distance.
  [[nodiscard]] RangeMotion measure(std::span<const RangePoint> points) const;
  [[nodiscard]] std::size_t planes() const { return planes_.size(); }

 private:
  /// 1 / depth = a + b u + c v.
  struct Plane {
    float a, b, c;
    float distance;               ///< From the sensor, m.
    float noise;                  ///< Of a point along the normal, m.
    float weight;                 ///< Less than 1 where few points made the plane.
    Vector6d distance_by_motion;  ///< How a point's distance from the plane changes with the sensor's motion.
  };
  struct Sums {
    double n = 0.0, u = 0.0, v = 0.0, uu = 0.0, uv = 0.0, vv = 0.0;
    double d = 0.0, du = 0.0, dv = 0.0, dd = 0.0;  ///< d: inverse depth.
  };
  struct Offset {
    float count = 0.0F;
    float weight = 0.0F;
    float weighted = 0.0F;
  };
  void add(const RangePoint& point);
  void fit(std::int32_t cell, const Sums& sums);
  void weigh();

  std::vector<std::int32_t> plane_of_cell_;  ///< -1: none.
  std::vector<std::int32_t> sums_of_cell_;
  std::vector<Plane> planes_;
  std::vector<std::int32_t> cells_;      ///< Those with sums, in the order of their first point,
  std::vector<Sums> sums_;               ///< and their sums.
  mutable std::vector<Offset> offsets_;  ///< Of a call of `measure`, by plane: kept for its memory.
};

}  // namespace rigcal
