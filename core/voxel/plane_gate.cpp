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

// Cells of one patch in one tangential bin, judged together.
struct Column {
  std::uint32_t patch = 0;
  std::int64_t bin = 0;
  std::uint32_t first = 0;  // range in the order array
  std::uint32_t count = 0;
  double N = 0.0;
  Vector3d mean = Vector3d::Zero();
  double variance = 0.0;  // of one point along the normal, by the noise model
  bool kept = true;
};

class Gate {
 public:
  Gate(std::span<const WorldCell> cells, const GateContext& context) : cells_(cells), context_(context) {}

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
      order_[i] = {(a + 512) * 1024 + (b + 512), i};
    }
    columns_.clear();
    std::size_t begin = 0;
    while (begin < cells_.size()) {
      std::size_t end = begin;
      while (end < cells_.size() && cells_[end].patch == cells_[begin].patch) ++end;
      std::sort(order_.begin() + static_cast<std::ptrdiff_t>(begin), order_.begin() + static_cast<std::ptrdiff_t>(end));
      for (std::size_t i = begin; i < end; ++i) {
        if (i == begin || order_[i].first != order_[i - 1].first) {
          columns_.push_back({cells_[begin].patch, order_[i].first, static_cast<std::uint32_t>(i)});
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
    return cells_[order_[column.first + i].second];
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
    Matrix3d scatter = Matrix3d::Zero();
    for (const Column& column : columns_) {
      if (!column.kept) continue;
      const double w = 1.0 / column.variance;
      for (std::uint32_t i = 0; i < column.count; ++i) {
        const WorldCell& cell = cell_of(column, i);
        const Vector3d d = cell.mean - q;
        scatter += w * (full(cell.scatter) + cell.N * d * d.transpose());
      }
    }
    const SymmetricEigen eigen = symmetric_eigen_fast(scatter);
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

  void add_observation(std::span<const Column> columns, PlaneFeature& feature, std::size_t& kept_cells) const {
    const PatchCells& patch = context_.patches[columns[0].patch];
    const NoiseModel& noise = context_.noise[static_cast<std::size_t>(patch.lidar)];
    PlaneObservation o;
    o.stop = patch.stop;
    o.lidar = patch.lidar;
    double variance = 0.0;
    for (const Column& column : columns) {
      if (!column.kept) continue;
      variance += column.N * column.variance;
      for (std::uint32_t i = 0; i < column.count; ++i) {
        const Cell& cell = patch.cells[cell_of(column, i).cell];
        o.N += cell.N;
        o.mean += cell.N * cell.mean;
        ++kept_cells;
      }
    }
    if (o.N < 1.0) return;
    o.mean /= o.N;
    variance /= o.N;
    for (const Column& column : columns) {
      if (!column.kept) continue;
      for (std::uint32_t i = 0; i < column.count; ++i) {
        const Cell& cell = patch.cells[cell_of(column, i).cell];
        const Vector3d d = cell.mean - o.mean;
        // Range noise lies along the ray and would turn the plane (a torque of sigma^2 cos i): its share goes out.
        o.scatter += cell.scatter_matrix() + cell.N * d * d.transpose() - cell.N * noise.point_covariance(cell.mean);
      }
    }
    const double floor = context_.options.offset_floor_m * context_.options.offset_floor_m;
    o.offset_variance = variance / o.N + floor;
    o.weight = 1.0 / (variance + o.N * floor);
    feature.observations.push_back(o);
    if (context_.options.with_rays) feature.rays.push_back(rays_of(columns, patch, noise, o));
  }

  static Matrix3d across(const Vector3d& d) { return Matrix3d::Identity() - d * d.transpose(); }

  // Within a cell the directions change with the points: d(p) = d + (1 - d d^T)(p - mean) / range.
  RayMoments rays_of(std::span<const Column> columns, const PatchCells& patch, const NoiseModel& noise,
                     const PlaneObservation& o) const {
    RayMoments rays;
    for_each_kept(columns, patch, [&](const Cell& cell) { rays.mean += cell.N * cell.mean.normalized(); });
    rays.mean /= o.N;
    for_each_kept(columns, patch, [&](const Cell& cell) {
      const double range = cell.mean.norm();
      const Vector3d d = cell.mean / range;
      const Matrix3d own = (cell.scatter_matrix() - cell.N * noise.point_covariance(cell.mean)) * across(d) / range;
      rays.cross += own + cell.N * (cell.mean - o.mean) * (d - rays.mean).transpose();
      rays.scatter += across(d) * own / range + cell.N * (d - rays.mean) * (d - rays.mean).transpose();
    });
    return rays;
  }

  template <class F>
  void for_each_kept(std::span<const Column> columns, const PatchCells& patch, const F& f) const {
    for (const Column& column : columns) {
      if (!column.kept) continue;
      for (std::uint32_t i = 0; i < column.count; ++i) f(patch.cells[cell_of(column, i).cell]);
    }
  }

  std::span<const WorldCell> cells_;
  const GateContext& context_;
  Vector3d q_ = Vector3d::Zero();
  Vector3d u_ = Vector3d::UnitZ();
  std::vector<std::pair<std::int64_t, std::uint32_t>> order_;
  std::vector<Column> columns_;
};

}  // namespace

CellTotal total_of(std::span<const WorldCell> cells) {
  CellTotal total;
  for (const WorldCell& cell : cells) {
    total.N += cell.N;
    total.mean += cell.N * cell.mean;
  }
  total.mean /= total.N;
  Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
  for (const WorldCell& cell : cells) {
    const Vector3d d = cell.mean - total.mean;
    sum += cell.scatter;
    sum[0] += cell.N * d.x() * d.x();
    sum[1] += cell.N * d.x() * d.y();
    sum[2] += cell.N * d.x() * d.z();
    sum[3] += cell.N * d.y() * d.y();
    sum[4] += cell.N * d.y() * d.z();
    sum[5] += cell.N * d.z() * d.z();
  }
  total.scatter = full(sum);
  return total;
}

PlaneVerdict gate_plane(std::span<const WorldCell> cells, const CellTotal& total, const GateContext& context,
                        PlaneFeature& feature, std::size_t& kept) {
  Gate gate(cells, context);
  return gate.run(total, feature, kept);
}

}  // namespace rigcal
