#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/geometry/se3.h"

namespace rigcal {

/// Two surfels are of one surface where they lie within this of each other's plane and face the same way, within 14
/// degrees.
inline constexpr double same_surface_m = 0.06;
inline const double same_surface_cosine = std::cos(to_rad(14.0));

/// A surfel placed in the frame of an index, with a group (for example its patch) that a query may leave out.
struct PlacedSurfel {
  Vector3d mean = Vector3d::Zero();
  Vector3d normal = Vector3d::UnitZ();
  int group = 0;
};

/// Finds the surfel nearest to a place among those that face the same way. Every surfel is entered in the voxels around
/// it, so a query is one look-up.
class SurfelIndex {
 public:
  /// `reach_m`: how far a surfel's mean may be from a query to be found surely; the voxels are that large.
  SurfelIndex(std::vector<PlacedSurfel> surfels, double reach_m);

  /// Index of the surfel whose mean is nearest to `p` among those with n.n' >= min_cosine, a distance of `p` from its
  /// plane of at most `max_plane_distance_m`, and another group than `not_group` (-1: any); or -1.
  [[nodiscard]] int find(const Vector3d& p, const Vector3d& normal, double min_cosine, double max_plane_distance_m,
                         int not_group = -1) const;
  /// Whether `find` with any group would find one; stops at the first.
  [[nodiscard]] bool contains(const Vector3d& p, const Vector3d& normal, double min_cosine,
                              double max_plane_distance_m) const;
  /// The nearest of each other group, at most `most` (and 16) of them, nearest first; like `find` else. Replaces `out`.
  void find_all(const Vector3d& p, const Vector3d& normal, double min_cosine, double max_plane_distance_m,
                int not_group, int most, std::vector<int>& out) const;
  [[nodiscard]] const PlacedSurfel& operator[](int i) const { return surfels_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] std::size_t size() const { return surfels_.size(); }

 private:
  template <class Take>
  void for_each_fit(const Vector3d& p, const Vector3d& normal, double min_cosine, double max_plane_distance_m,
                    const Take& take) const;

  std::vector<PlacedSurfel> surfels_;
  double voxel_m_;
  std::size_t mask_ = 0;
  std::vector<std::uint32_t> bucket_start_;  // entries of each bucket, one list after the other
  // Copies of the surfels' normals and means, coordinate by coordinate: a query reads one stretch of each. They have
  // room for one more look at the end.
  std::array<std::vector<float>, 6> entries_;
  std::vector<std::int32_t> group_;
  std::vector<std::int32_t> surfel_;
};

/// One surfel for each direction (within 15 degrees) in each cube of `size_m`, the first met: what many stops have seen
/// alike is kept once.
[[nodiscard]] std::vector<PlacedSurfel> without_repetitions(const std::vector<PlacedSurfel>& surfels, double size_m);

}  // namespace rigcal
