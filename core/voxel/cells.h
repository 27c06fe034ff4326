#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/point_cluster.h"
#include "core/records/records.h"

namespace rigcal {

/// The points of one patch in one small cube of the sensor's own grid: count, mean and scatter sum (p - mean)(p -
/// mean)^T, in metres in the sensor's frame. Points are read once; from here on only cells are moved and added.
struct Cell {
  double N = 0.0;
  Vector3d mean = Vector3d::Zero();
  Eigen::Matrix<double, 6, 1> scatter = Eigen::Matrix<double, 6, 1>::Zero();  ///< xx xy xz yy yz zz

  [[nodiscard]] Matrix3d scatter_matrix() const {
    Matrix3d S;
    S << scatter[0], scatter[1], scatter[2], scatter[1], scatter[3], scatter[4], scatter[2], scatter[4], scatter[5];
    return S;
  }
};

/// All cells of what one LiDAR saw in one stop.
struct PatchCells {
  int lidar = 0;
  int stop = 0;
  std::uint64_t points = 0;  ///< Points that went in.
  std::vector<Cell> cells;
  std::vector<Point> thinned;  ///< One point for each 2 cm, for the fused map; empty unless asked for.
};

struct CellOptions {
  double size_m = 0.2;        ///< Edge of a cell; 5 to 25 cm give the same accuracy, larger cells fail in rooms.
  double max_range_m = 60.0;  ///< Farther points carry angle noise of several centimetres.
  bool keep_thinned = false;  ///< Keep one point for each 2 cm for the fused map.
};

/// Sums points into cells as they come, in memory that grows with the surface seen and not with the points.
class CellBuilder {
 public:
  CellBuilder(int lidar, int stop, const CellOptions& options);
  ~CellBuilder();
  CellBuilder(CellBuilder&&) noexcept;
  CellBuilder& operator=(CellBuilder&&) noexcept;

  void add(std::span<const Point> points);
  /// The cells in the order in which they were first hit; the builder is empty afterwards.
  [[nodiscard]] PatchCells finish();

 private:
  struct Table;
  std::unique_ptr<Table> table_;
};

}  // namespace rigcal
