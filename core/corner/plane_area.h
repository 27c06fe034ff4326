#pragma once

#include <cstdint>
#include <vector>

#include "core/corner/fitted_plane.h"

namespace rigcal {

/// Where on a plane it was seen: square parts of it in which most points near it lie on it. The parts are laid out
/// along the directions in which its points spread, so that they are the same whatever the frame.
class PlaneArea {
 public:
  /// Counts `points` near `plane`; those within 2.5 sigmas are on it, those within 7.5 around it.
  PlaneArea(const FittedPlane& plane, const std::vector<Vector3d>& points, double part_m);

  /// The parts that at least two of `areas` have. All of them are of the same plane and part size.
  [[nodiscard]] static PlaneArea common(const std::vector<PlaneArea>& areas);

  /// Number of the part that holds p, or -1 where the plane was not seen.
  [[nodiscard]] int part_of(const Vector3d& p) const;
  [[nodiscard]] int parts() const { return parts_; }
  [[nodiscard]] double area_m2() const { return parts_ * part_m_ * part_m_; }

 private:
  [[nodiscard]] std::int64_t slot_of(const Vector3d& p) const;

  Vector3d center_ = Vector3d::Zero();
  Vector3d along_ = Vector3d::UnitX();
  Vector3d across_ = Vector3d::UnitY();
  double part_m_;
  int parts_ = 0;
  static constexpr std::int64_t side_ = 256;
  std::vector<int> number_;  ///< Of each of side_ x side_ slots; -1: not seen.
};

}  // namespace rigcal
