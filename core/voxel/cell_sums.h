#pragma once

#include <array>
#include <cstdint>

#include "core/voxel/cells.h"

namespace rigcal {

/// Sums of points about a cell's middle: small numbers, so no digits are lost, and one fixed point for all of a cell.
struct CellSums {
  double n = 0.0;
  double vx = 0.0, vy = 0.0, vz = 0.0;
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;

  void add(double x, double y, double z) {
    n += 1.0;
    vx += x;
    vy += y;
    vz += z;
    xx += x * x;
    xy += x * y;
    xz += x * z;
    yy += y * y;
    yz += y * z;
    zz += z * z;
  }
  CellSums& operator+=(const CellSums& other) {
    n += other.n;
    vx += other.vx;
    vy += other.vy;
    vz += other.vz;
    xx += other.xx;
    xy += other.xy;
    xz += other.xz;
    yy += other.yy;
    yz += other.yz;
    zz += other.zz;
    return *this;
  }
  /// Makes sums about a middle of those about another, which stands off it by (x, y, z).
  void move(double x, double y, double z) {
    xx += 2.0 * x * vx + n * x * x;
    xy += x * vy + y * vx + n * x * y;
    xz += x * vz + z * vx + n * x * z;
    yy += 2.0 * y * vy + n * y * y;
    yz += y * vz + z * vy + n * y * z;
    zz += 2.0 * z * vz + n * z * z;
    vx += n * x;
    vy += n * y;
    vz += n * z;
  }
  /// `middle`: what the sums are about, in the sensor's frame.
  [[nodiscard]] Cell about(const Vector3d& middle) const {
    Cell cell;
    const double inverse = 1.0 / n;
    const double mx = vx * inverse;
    const double my = vy * inverse;
    const double mz = vz * inverse;
    cell.N = n;
    cell.mean = Vector3d(mx, my, mz) + middle;
    cell.scatter << xx - vx * mx, xy - vx * my, xz - vx * mz, yy - vy * my, yz - vy * mz, zz - vz * mz;
    return cell;
  }
};

/// Points are taken in blocks: what the next ones need is brought from memory while these are added.
constexpr std::size_t cell_block = 128;

template <class Value>
using EachOfBlock = std::array<Value, cell_block>;

/// Coordinate by coordinate, in metres in the sensor's frame. Those behind `count` are zero: what is done with all of a
/// block needs numbers that fit.
struct PointBlock {
  std::size_t count = 0;
  std::array<EachOfBlock<float>, 3> at;
  EachOfBlock<const Point*> point;
};

/// For numbers that fit.
inline std::int32_t small_floor_of(double value) {
  const auto whole = static_cast<std::int32_t>(value);
  return whole - static_cast<std::int32_t>(static_cast<double>(whole) > value);
}

}  // namespace rigcal
