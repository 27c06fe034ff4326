#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry/point_cluster.h"
#include "core/records/records.h"

namespace rigcal {

/// The points of one patch in one small cube of the sensor's own grid: count, mean and
/// scatter sum (p - mean)(p - mean)^T, in metres in the sensor's frame. Points are read once; from here on only cells
/// are moved and added.
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

/// A cell whose points are no flat piece, and where its octants begin among the parts of its patch; they end where
/// those of the next divided cell begin.
struct DividedCell {
  std::uint32_t cell = 0;
  std::uint32_t first_part = 0;
};

/// All cells of what one LiDAR saw in one stop.
struct PatchCells {
  int lidar = 0;
  int stop = 0;
  std::uint64_t points = 0;  ///< Points that went in.
  std::vector<Cell> cells;
  /// Where two surfaces meet, a cell belongs to neither: such ones are here once more, by octants. Ascending by
  /// cell.
  std::vector<DividedCell> divided;
  std::vector<Cell> parts;
  std::vector<Point> thinned;  ///< One point for each 2 cm, for the fused map; empty unless asked for.
};

/// The finest cells of a patch, each point in one: those that are not divided, and the parts of the others.
class FinestCells {
 public:
  explicit FinestCells(const PatchCells& patch) : patch_(patch) {}

  [[nodiscard]] std::size_t count() const { return patch_.cells.size() - patch_.divided.size() + patch_.parts.size(); }
  /// Cells have the numbers below `cells.size()`, parts those from there on.
  [[nodiscard]] const Cell& operator[](std::uint32_t number) const {
    return number < patch_.cells.size() ? patch_.cells[number] : patch_.parts[number - patch_.cells.size()];
  }
  /// Calls f(number) for each, the parts of a cell in its place.
  template <class F>
  void for_each(const F& f) const {
    const auto cells = static_cast<std::uint32_t>(patch_.cells.size());
    std::uint32_t next = 0;
    for (std::size_t k = 0; k < patch_.divided.size(); ++k) {
      for (; next < patch_.divided[k].cell; ++next) f(next);
      const std::size_t end = k + 1 < patch_.divided.size() ? patch_.divided[k + 1].first_part : patch_.parts.size();
      for (std::uint32_t part = patch_.divided[k].first_part; part < end; ++part) f(cells + part);
      ++next;
    }
    for (; next < cells; ++next) f(next);
  }

 private:
  const PatchCells& patch_;
};

struct CellOptions {
  double size_m = 0.2;        ///< Edge of a cell; larger ones fail in rooms.
  double max_range_m = 60.0;  ///< Farther points carry angle noise of several centimetres.
  bool keep_thinned = false;  ///< Keep one point for each 2 cm for the fused map.
};

/// Sums points into cells as they come, in memory that grows with the surface seen and not with the points.
class CellBuilder {
 public:
  CellBuilder() : CellBuilder(0, 0, {}) {}
  CellBuilder(int lidar, int stop, const CellOptions& options);
  ~CellBuilder();
  CellBuilder(CellBuilder&&) noexcept;
  CellBuilder& operator=(CellBuilder&&) noexcept;

  void add(std::span<const Point> points);
  /// The cells in the order in which they were first hit; the builder is empty afterwards and keeps its memory.
  [[nodiscard]] PatchCells finish();
  /// What is added from now on is of this patch; forgets what was added and not finished.
  void begin(int lidar, int stop, const CellOptions& options);

 private:
  struct Table;
  std::unique_ptr<Table> table_;
};

}  // namespace rigcal
