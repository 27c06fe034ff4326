#include "core/voxel/gate_columns.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/floor_of.h"

namespace rigcal {
namespace {

constexpr double column_size_m = 0.25;  // Tangential size of what is gated as one.

// Puts a mean back along its ray, as far as borders that sort points by their noise have moved it.
void undo_shift(const Vector3d& sensor_G, const NoiseModel& noise, const Vector3d& normal_G, GateCell& cell) {
  if (cell.noise_shift_per_m == 0.0F) return;
  const Vector3d p = cell.mean - sensor_G;
  const double range = std::max(1e-3, p.norm());
  const double variance = noise.range_variance(range * range, std::abs(normal_G.dot(p)) / range);
  const Vector3d shift = cell.noise_shift_per_m * variance / range * p;
  cell.mean -= shift;
  cell.put_back_m = static_cast<float>(normal_G.dot(shift));
}

}  // namespace

void GateColumns::make(std::span<const WorldCell> cells, const GateContext& context, const Vector3d& origin_G,
                       const Vector3d& normal_G) {
  sort(cells, context, origin_G, normal_G);
  cells_.clear();
  for (const std::uint64_t each : order_) {
    const WorldCell& cell = cells[each & 0xFFFFFFFFU];
    cells_.push_back(
        {cell.N, cell.mean, cell.scatter, cell.noise_share, cell.noise_shift_per_m, cell.darkness, 0.0F, true});
  }
  columns_.clear();
  patches_.clear();
  std::uint32_t begin = 0;
  for (const std::uint32_t number : present_) {
    const std::uint32_t end = next_[number];
    PatchColumns& patch = patches_.emplace_back();
    patch.number = number;
    patch.first = static_cast<std::uint32_t>(columns_.size());
    const PatchCells& seen = context.patches[number];
    patch.T_G_sensor = context.state.T_G_sensor(seen.stop, seen.lidar);
    const NoiseModel& noise = context.noise[static_cast<std::size_t>(seen.lidar)];
    for (std::uint32_t i = begin; i < end; ++i) {
      undo_shift(patch.T_G_sensor.t, noise, normal_G, cells_[i]);
      if (i == begin || order_[i] >> 32 != order_[i - 1] >> 32) columns_.emplace_back().first = i;
      ++columns_.back().count;
    }
    patch.end = static_cast<std::uint32_t>(columns_.size());
    next_[number] = 0;
    begin = end;
  }
  for (GateColumn& column : columns_) sum_up(column);
}

void GateColumns::sum_up(GateColumn& column) {
  column.N = 0.0;
  column.scatter.setZero();
  Vector3d sum = Vector3d::Zero();
  for_each_kept(column, [&](const GateCell& cell) {
    column.N += cell.N;
    sum += cell.N * cell.mean;
  });
  if (column.N == 0.0) return;
  column.mean = sum / column.N;
  for_each_kept(column, [&](const GateCell& cell) {
    column.scatter += cell.scatter;
    add_square(cell.N, cell.mean - column.mean, column.scatter);
  });
}

// Leaves in `next_` where the cells of each patch end.
void GateColumns::sort(std::span<const WorldCell> cells, const GateContext& context, const Vector3d& origin_G,
                       const Vector3d& normal_G) {
  // Any two directions across the first normal serve; they are kept while the plane is refitted.
  const Vector3d t1 = normal_G.unitOrthogonal();
  const Vector3d t2 = normal_G.cross(t1);
  const double inverse = 1.0 / column_size_m;
  if (next_.size() < context.patches.size()) next_.resize(context.patches.size(), 0);
  present_.clear();
  for (const WorldCell& cell : cells) {
    if (next_[cell.patch]++ == 0) present_.push_back(cell.patch);
  }
  std::sort(present_.begin(), present_.end());
  std::uint32_t begin = 0;
  for (const std::uint32_t patch : present_) {
    const std::uint32_t count = next_[patch];
    next_[patch] = begin;
    begin += count;
  }
  order_.resize(cells.size());
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    const Vector3d d = cells[i].mean - origin_G;
    const std::int64_t a = floor_of(t1.dot(d) * inverse);
    const std::int64_t b = floor_of(t2.dot(d) * inverse);
    order_[next_[cells[i].patch]++] = static_cast<std::uint64_t>((a + 512) * 1024 + (b + 512)) << 32 | i;
  }
  begin = 0;
  for (const std::uint32_t patch : present_) {
    std::sort(order_.begin() + begin, order_.begin() + next_[patch]);
    begin = next_[patch];
  }
}

}  // namespace rigcal
