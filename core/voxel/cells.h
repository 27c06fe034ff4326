#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/point_cluster.h"
#include "core/records/records.h"
#include "core/voxel/upper_triangle.h"

namespace rigcal {

/// Some points of one patch that lie close together: count, mean and scatter sum (p - mean)(p - mean)^T, in metres in
/// the sensor's frame. Points are read once; from here on only cells are moved and added.
struct Cell {
  double N = 0.0;
  Vector3d mean = Vector3d::Zero();
  UpperTriangle scatter = UpperTriangle::Zero();
  /// Where a surface goes on beyond a border across the rays, points are sorted there by the noise of their ranges.
  /// Of the covariance of noise and place on the surface so much is left (1: all, as is said of all cubes),
  float noise_share = 1.0F;
  /// and the mean is moved away from the sensor, along the ray, by this (1/m) times the variance of ranges (m^2).
  float noise_shift_per_m = 0.0F;
  /// Mean of its points (darkness_of): ranges of dark surfaces may be off by more than those of bright ones. Of a
  /// piece; cubes do not know theirs.
  float darkness = 0.0F;

  [[nodiscard]] Matrix3d scatter_matrix() const { return full(scatter); }
  friend bool operator==(const Cell&, const Cell&) = default;
};

/// How far a reflectivity is from white: 1 where nothing comes back, 0 from 100 (of 255) on, which is white on Livox'
/// scale and brighter than white above it.
[[nodiscard]] constexpr float darkness_of(std::uint8_t reflectivity) {
  return reflectivity < 100 ? static_cast<float>(100 - reflectivity) / 100.0F : 0.0F;
}

/// All cells of what one LiDAR saw in one stop, by two ways to divide it: each point is once in either.
struct PatchCells {
  int lidar = 0;
  int stop = 0;
  std::uint64_t points = 0;  ///< Points that went in.
  /// Cubes of the sensor's grid: what finds the rig goes by them.
  std::vector<Cell> cells;
  /// Pieces of surface by direction as the sensor sees them, flat as far as their points tell: what planes are made of.
  std::vector<Cell> pieces;
  std::vector<Point> thinned;  ///< One point for each 2 cm, for the fused map; empty unless asked for.
  std::uint64_t too_far = 0;   ///< Points left out beyond CellOptions::max_range_m.
};

struct CellOptions {
  double size_m = 0.2;        ///< Edge of a cube, and depth of a piece; larger ones fail in rooms.
  double max_range_m = 60.0;  ///< Farther points carry angle noise of several centimetres.
  bool keep_thinned = false;  ///< Keep one point for each 2 cm for the fused map.
};

/// Sums points into cells as they come, in memory that grows with the surface seen and not with the points (but for
/// some 260 000 that wait to be summed).
class CellBuilder {
 public:
  CellBuilder() : CellBuilder(0, 0, {}) {}
  CellBuilder(int lidar, int stop, const CellOptions& options);
  ~CellBuilder();
  CellBuilder(CellBuilder&&) noexcept;
  CellBuilder& operator=(CellBuilder&&) noexcept;

  void add(std::span<const Point> points);
  /// The cubes in the order in which they were first hit, the pieces by direction and then by depth; the builder is
  /// empty afterwards and keeps its memory.
  [[nodiscard]] PatchCells finish();
  /// What is added from now on is of this patch; forgets what was added and not finished.
  void begin(int lidar, int stop, const CellOptions& options);

 private:
  struct Tables;
  std::unique_ptr<Tables> tables_;
};

}  // namespace rigcal
