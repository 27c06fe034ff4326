#include "core/voxel/plane_gate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/floor_of.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

Matrix3d full(const Eigen::Matrix<double, 6, 1>& s) {
  Matrix3d S;
  S << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  return S;
}

double along(const Eigen::Matrix<double, 6, 1>& s, const Vector3d& u) {
  return s[0] * u.x() * u.x() + s[3] * u.y() * u.y() + s[5] * u.z() * u.z() +
         2.0 * (s[1] * u.x() * u.y() + s[2] * u.x() * u.z() + s[4] * u.y() * u.z());
}

using Upper = Eigen::Matrix<double, 6, 1>;  // of a symmetric matrix: xx xy xz yy yz zz

// sum += w d d^T
void add_square(double w, const Vector3d& d, Upper& sum) {
  sum[0] += w * d.x() * d.x();
  sum[1] += w * d.x() * d.y();
  sum[2] += w * d.x() * d.z();
  sum[3] += w * d.y() * d.y();
  sum[4] += w * d.y() * d.z();
  sum[5] += w * d.z() * d.z();
}

// Cells of one patch in one tangential bin, judged together.
struct Column {
  std::uint32_t patch = 0;
  std::uint32_t first = 0;  // range in the order array
  std::uint32_t count = 0;
  double N = 0.0;
  Vector3d mean = Vector3d::Zero();
  double variance = 0.0;  // of one point along the normal, by the noise model
  bool kept = true;
};

// What is used again for the next voxel.
struct GateRoom {
  std::vector<std::uint64_t> order;
  std::vector<Column> columns;
};

class Gate {
 public:
  Gate(std::span<const WorldCell> cells, const GateContext& context, GateRoom& room)
      : cells_(cells), context_(context), order_(room.order), columns_(room.columns) {}

  PlaneVerdict run(const CellTotal& total, PlaneFeature& feature, std::size_t& kept_cells) {
    const PlaneMapOptions& o = context_.options;
    q_ = total.mean;
    u_ = symmetric_eigen_fast(total.scatter).vectors.col(0);
    make_columns();
    double kept_share = 0.0;
    double chi2 = 0.0;
    for (int round = 0; round < 4; ++round) {
      const bool changed = judge();
      if (!refit(total.N, kept_share, chi2)) return PlaneVerdict::split;
      if (!changed && round > 0) break;
    }
    if (kept_share < o.min_kept || chi2 > o.max_chi2) return PlaneVerdict::split;
    return collect(feature, kept_cells) ? PlaneVerdict::plane : PlaneVerdict::split;
  }

 private:
  void make_columns() {
    // Any two directions across the first normal serve; they are kept while the plane is refitted.
    const Vector3d t1 = u_.unitOrthogonal();
    const Vector3d t2 = u_.cross(t1);
    const double inverse = 1.0 / context_.options.column_size_m;
    order_.resize(cells_.size());
    for (std::uint32_t i = 0; i < order_.size(); ++i) {
      const Vector3d d = cells_[i].mean - q_;
      const std::int64_t a = floor_of(t1.dot(d) * inverse);
      const std::int64_t b = floor_of(t2.dot(d) * inverse);
      order_[i] = static_cast<std::uint64_t>((a + 512) * 1024 + (b + 512)) << 32 | i;
    }
    columns_.clear();
    std::size_t begin = 0;
    while (begin < cells_.size()) {
      std::size_t end = begin;
      while (end < cells_.size() && cells_[end].patch == cells_[begin].patch) ++end;
      std::sort(order_.begin() + static_cast<std::ptrdiff_t>(begin), order_.begin() + static_cast<std::ptrdiff_t>(end));
      for (std::size_t i = begin; i < end; ++i) {
        if (i == begin || order_[i] >> 32 != order_[i - 1] >> 32) {
          columns_.push_back({cells_[begin].patch, static_cast<std::uint32_t>(i)});
        }
        ++columns_.back().count;
      }
      begin = end;
    }
    for (Column& column : columns_) {
      for (std::uint32_t i = 0; i < column.count; ++i) {
        const WorldCell& cell = cell_of(column, i);
        column.N += cell.N;
        column.mean += cell.N * cell.mean;
      }
      column.mean /= column.N;
    }
  }

  const WorldCell& cell_of(const Column& column, std::uint32_t i) const {
    return cells_[order_[column.first + i] & 0xFFFFFFFFU];
  }

  double scatter_along_normal(const Column& column) const {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < column.count; ++i) {
      const WorldCell& cell = cell_of(column, i);
      const double d = u_.dot(cell.mean - column.mean);
      sum += along(cell.scatter, u_) + cell.N * d * d;
    }
    return sum;
  }

  // Decides for every column whether it lies on the plane (q_, u_); true when any changed its mind.
  bool judge() {
    const PlaneMapOptions& o = context_.options;
    const double slack2 = o.gate_slack_m * o.gate_slack_m;
    bool changed = false;
    const Column* last = nullptr;
    SE3 T_sensor_G;
    for (Column& column : columns_) {
      const PatchCells& patch = context_.patches[column.patch];
      // Columns of one patch stand together.
      if (last == nullptr || last->patch != column.patch)
        T_sensor_G = context_.state.T_G_sensor(patch.stop, patch.lidar).inverse();
      last = &column;
      const Vector3d p = T_sensor_G * column.mean;
      column.variance = context_.noise[static_cast<std::size_t>(patch.lidar)].variance_along(p, T_sensor_G.R * u_);
      const double offset = u_.dot(column.mean - q_);
      const double allowed =
          o.gate_sigmas * std::sqrt(column.variance / column.N + o.offset_floor_m * o.offset_floor_m) + o.gate_slack_m;
      bool keep = std::abs(offset) <= allowed;
      if (keep && column.N >= 3.0) {
        const double thickness2 = scatter_along_normal(column) / column.N;
        // 1.69: thirty per cent thicker than the noise says is still the same surface.
        keep = thickness2 <= 1.69 * (column.variance + slack2) * (1.0 + 4.0 * std::sqrt(2.0 / column.N));
      }
      changed |= keep != column.kept;
      column.kept = keep;
    }
    return changed;
  }

  // The plane of the kept columns, each weighted by its noise. False where too little is left.
  bool refit(double all_points, double& kept_share, double& chi2) {
    double weight = 0.0;
    double points = 0.0;
    Vector3d q = Vector3d::Zero();
    for (const Column& column : columns_) {
      if (!column.kept) continue;
      const double w = column.N / column.variance;
      weight += w;
      points += column.N;
      q += w * column.mean;
    }
    kept_share = points / all_points;
    if (points < context_.options.min_points || kept_share < 0.5 * context_.options.min_kept) return false;
    q /= weight;
    Upper scatter = Upper::Zero();
    for (const Column& column : columns_) {
      if (!column.kept) continue;
      const double w = 1.0 / column.variance;
      for (std::uint32_t i = 0; i < column.count; ++i) {
        const WorldCell& cell = cell_of(column, i);
        scatter += w * cell.scatter;
        add_square(w * cell.N, cell.mean - q, scatter);
      }
    }
    const SymmetricEigen eigen = symmetric_eigen_fast(full(scatter));
    q_ = q;
    u_ = eigen.vectors.col(0);
    const double slack = context_.options.gate_slack_m;
    chi2 = eigen.values[0] / (points * (1.0 + slack * slack * weight / points));
    return true;
  }

  bool collect(PlaneFeature& feature, std::size_t& kept_cells) const {
    feature.observations.clear();
    feature.rays.clear();
    feature.center_G = q_;
    feature.normal_G = u_;
    std::size_t begin = 0;
    while (begin < columns_.size()) {
      std::size_t end = begin;
      while (end < columns_.size() && columns_[end].patch == columns_[begin].patch) ++end;
      add_observation(std::span(columns_).subspan(begin, end - begin), feature, kept_cells);
      begin = end;
    }
    return feature.observations.size() >= context_.options.min_patches;
  }

  // All sums are made in the world's directions, about the sensor: its cells need not be looked up again.
  void add_observation(std::span<const Column> columns, PlaneFeature& feature, std::size_t& kept_cells) const {
    const PatchCells& patch = context_.patches[columns[0].patch];
    const NoiseModel& noise = context_.noise[static_cast<std::size_t>(patch.lidar)];
    const SE3 T_G_sensor = context_.state.T_G_sensor(patch.stop, patch.lidar);
    PlaneObservation o;
    o.stop = patch.stop;
    o.lidar = patch.lidar;
    double variance = 0.0;
    Vector3d mean = Vector3d::Zero();
    for (const Column& column : columns) {
      if (!column.kept) continue;
      variance += column.N * column.variance;
      o.N += column.N;
      mean += column.N * column.mean;
      kept_cells += column.count;
    }
    if (o.N < 1.0) return;
    mean /= o.N;
    variance /= o.N;
    Upper scatter = Upper::Zero();
    for_each_kept(columns, [&](const WorldCell& cell) {
      // Range noise lies along the ray and would turn the plane (a torque of sigma^2 cos i): its share goes out.
      scatter += without_noise(cell, cell.mean - T_G_sensor.t, noise);
      add_square(cell.N, cell.mean - mean, scatter);
    });
    o.mean = T_G_sensor.R.transpose() * (mean - T_G_sensor.t);
    o.scatter = in_sensor(full(scatter), T_G_sensor);
    const double floor = context_.options.offset_floor_m * context_.options.offset_floor_m;
    o.offset_variance = variance / o.N + floor;
    o.weight = 1.0 / (variance + o.N * floor);
    feature.observations.push_back(o);
    if (context_.options.with_rays) feature.rays.push_back(rays_of(columns, T_G_sensor, noise, o.N, mean));
  }

  static Matrix3d across(const Vector3d& d) { return Matrix3d::Identity() - d * d.transpose(); }

  // A matrix in the directions of the world in those of the sensor.
  static Matrix3d in_sensor(const Matrix3d& M, const SE3& T_G_sensor) {
    return T_G_sensor.R.transpose() * M * T_G_sensor.R;
  }

  // The scatter of a cell that lies at `p` from the sensor, the noise's own share taken out. A covariance along and
  // across a ray turns with the ray.
  static Upper without_noise(const WorldCell& cell, const Vector3d& p, const NoiseModel& noise) {
    const double r2 = p.squaredNorm();
    const double along = noise.range_m * noise.range_m + noise.range_per_m * noise.range_per_m * r2;
    const double aside = noise.angle_rad * noise.angle_rad * r2;
    Upper out = cell.scatter;
    add_square(-cell.N * (along - aside) / std::max(r2, 1e-12), p, out);
    out[0] -= cell.N * aside;
    out[3] -= cell.N * aside;
    out[5] -= cell.N * aside;
    return out;
  }

  // Within a cell the directions change with the points: d(p) = d + (1 - d d^T)(p - mean) / range.
  RayMoments rays_of(std::span<const Column> columns, const SE3& T_G_sensor, const NoiseModel& noise, double N,
                     const Vector3d& mean) const {
    RayMoments rays;
    for_each_kept(columns,
                  [&](const WorldCell& cell) { rays.mean += cell.N * (cell.mean - T_G_sensor.t).normalized(); });
    rays.mean /= N;
    for_each_kept(columns, [&](const WorldCell& cell) {
      const Vector3d p = cell.mean - T_G_sensor.t;
      const double range = p.norm();
      const Vector3d d = p / range;
      const Matrix3d own = full(without_noise(cell, p, noise)) * across(d) / range;
      rays.cross += own + cell.N * (cell.mean - mean) * (d - rays.mean).transpose();
      rays.scatter += across(d) * own / range + cell.N * (d - rays.mean) * (d - rays.mean).transpose();
    });
    rays.mean = T_G_sensor.R.transpose() * rays.mean;
    rays.cross = in_sensor(rays.cross, T_G_sensor);
    rays.scatter = in_sensor(rays.scatter, T_G_sensor);
    return rays;
  }

  template <class F>
  void for_each_kept(std::span<const Column> columns, const F& f) const {
    for (const Column& column : columns) {
      if (!column.kept) continue;
      for (std::uint32_t i = 0; i < column.count; ++i) f(cell_of(column, i));
    }
  }

  std::span<const WorldCell> cells_;
  const GateContext& context_;
  Vector3d q_ = Vector3d::Zero();
  Vector3d u_ = Vector3d::UnitZ();
  std::vector<std::uint64_t>& order_;  ///< Bin and cell, sorted within each patch.
  std::vector<Column>& columns_;
};

}  // namespace

CellTotal total_of(std::span<const WorldCell> cells) {
  CellTotal total;
  for (const WorldCell& cell : cells) {
    total.N += cell.N;
    total.mean += cell.N * cell.mean;
  }
  total.mean /= total.N;
  Upper sum = Upper::Zero();
  for (const WorldCell& cell : cells) {
    sum += cell.scatter;
    add_square(cell.N, cell.mean - total.mean, sum);
  }
  total.scatter = full(sum);
  return total;
}

PlaneVerdict gate_plane(std::span<const WorldCell> cells, const CellTotal& total, const GateContext& context,
                        PlaneFeature& feature, std::size_t& kept) {
  thread_local GateRoom room;
  Gate gate(cells, context, room);
  return gate.run(total, feature, kept);
}

}  // namespace rigcal
