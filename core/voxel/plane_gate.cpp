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

// What is summed up of a cell.
struct GateCell {
  double N;
  Vector3d mean;
  Upper scatter;
  bool kept;
};

// Cells of one patch in one tangential bin, judged together.
struct Column {
  std::uint32_t first = 0;  // of its cells
  std::uint32_t count = 0;
  double N = 0.0;
  Vector3d mean = Vector3d::Zero();
  Upper scatter = Upper::Zero();  // of its points about their mean
  double variance = 0.0;          // of one point along the normal, by the noise model
  bool kept = true;
};

// The columns of one patch, which stand together.
struct PatchRun {
  std::uint32_t patch = 0;
  std::uint32_t first = 0;  // of its columns
  std::uint32_t end = 0;
  SE3 T_G_sensor;
};

// What is used again for the next voxel.
struct GateRoom {
  std::vector<std::uint32_t> next;     // of each patch of all, where its next cell goes; 0 while no cell is there
  std::vector<std::uint32_t> patches;  // that have cells here
  std::vector<std::uint64_t> order;    // bin and cell, patch by patch, sorted within each
  std::vector<GateCell> cells;         // in that order
  std::vector<Column> columns;
  std::vector<PatchRun> runs;
};

// Of all observations of a plane, about a point of it, the noise's own share taken out.
struct WeightedSum {
  double N = 0.0;
  Vector3d moment = Vector3d::Zero();
  Upper square = Upper::Zero();
};

// Of the mean square width of a plane, what must not be noise.
constexpr double least_true_share = 0.5;

// A cell alone is judged more loosely than its column, and as if it had no more than so many points: half of a wall
// that a border cuts by its noise stands off by nearly as much as the noise itself.
constexpr double cell_sigmas = 4.0;
constexpr double most_points_judged = 4.0;
// Above the noise's own variance: in sigmas of what that comes out as, and what the noise's law may be off by.
constexpr double cell_thickness_sigmas = 3.0;
constexpr double law_share = 0.3;

class Gate {
 public:
  Gate(std::span<const WorldCell> cells, const GateContext& context, GateRoom& room)
      : cells_(cells), context_(context), room_(room), columns_(room.columns) {}

  PlaneVerdict run(const CellTotal& total, PlaneFeature& feature, std::size_t& kept_cells) {
    const PlaneMapOptions& o = context_.options;
    q_ = total.mean;
    const SymmetricEigen eigen = symmetric_eigen_fast(total.scatter);
    u_ = eigen.vectors.col(0);
    seen_width2_ = eigen.values[1] / total.N;
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
    sort_by_patch_and_bin();
    room_.cells.clear();
    for (const std::uint64_t each : room_.order) {
      const WorldCell& cell = cells_[each & 0xFFFFFFFFU];
      room_.cells.push_back({cell.N, cell.mean, cell.scatter, true});
    }
    columns_.clear();
    room_.runs.clear();
    std::uint32_t begin = 0;
    for (const std::uint32_t patch : room_.patches) {
      const std::uint32_t end = room_.next[patch];
      PatchRun& run = room_.runs.emplace_back();
      run.patch = patch;
      run.first = static_cast<std::uint32_t>(columns_.size());
      run.T_G_sensor = context_.state.T_G_sensor(context_.patches[patch].stop, context_.patches[patch].lidar);
      for (std::uint32_t i = begin; i < end; ++i) {
        if (i == begin || room_.order[i] >> 32 != room_.order[i - 1] >> 32) columns_.emplace_back().first = i;
        ++columns_.back().count;
      }
      run.end = static_cast<std::uint32_t>(columns_.size());
      room_.next[patch] = 0;
      begin = end;
    }
    for (Column& column : columns_) sum_up(column);
  }

  // Of the cells that are kept; where none is, the mean stays.
  void sum_up(Column& column) const {
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

  // Leaves in `next` where the cells of each patch end.
  void sort_by_patch_and_bin() {
    // Any two directions across the first normal serve; they are kept while the plane is refitted.
    const Vector3d t1 = u_.unitOrthogonal();
    const Vector3d t2 = u_.cross(t1);
    const double inverse = 1.0 / context_.options.column_size_m;
    std::vector<std::uint32_t>& next = room_.next;
    if (next.size() < context_.patches.size()) next.resize(context_.patches.size(), 0);
    room_.patches.clear();
    for (const WorldCell& cell : cells_) {
      if (next[cell.patch]++ == 0) room_.patches.push_back(cell.patch);
    }
    std::sort(room_.patches.begin(), room_.patches.end());
    std::uint32_t begin = 0;
    for (const std::uint32_t patch : room_.patches) {
      const std::uint32_t count = next[patch];
      next[patch] = begin;
      begin += count;
    }
    room_.order.resize(cells_.size());
    for (std::uint32_t i = 0; i < cells_.size(); ++i) {
      const Vector3d d = cells_[i].mean - q_;
      const std::int64_t a = floor_of(t1.dot(d) * inverse);
      const std::int64_t b = floor_of(t2.dot(d) * inverse);
      room_.order[next[cells_[i].patch]++] = static_cast<std::uint64_t>((a + 512) * 1024 + (b + 512)) << 32 | i;
    }
    begin = 0;
    for (const std::uint32_t patch : room_.patches) {
      std::sort(room_.order.begin() + begin, room_.order.begin() + next[patch]);
      begin = next[patch];
    }
  }

  [[nodiscard]] std::span<GateCell> cells_of(const Column& column) const {
    return std::span(room_.cells).subspan(column.first, column.count);
  }

  [[nodiscard]] std::span<Column> columns_of(const PatchRun& run) const {
    return std::span(columns_).subspan(run.first, run.end - run.first);
  }

  [[nodiscard]] const NoiseModel& noise_of(const PatchRun& run) const {
    return context_.noise[static_cast<std::size_t>(context_.patches[run.patch].lidar)];
  }

  // Leaves out cells of another surface that the column's mean and thickness hide: one of a few points, or one that
  // holds an edge. True when any changed its mind.
  bool judge_cells(Column& column) {
    const PlaneMapOptions& o = context_.options;
    bool changed = false;
    for (GateCell& cell : cells_of(column)) {
      const double offset = u_.dot(cell.mean - q_);
      const double variance =
          column.variance / std::min(cell.N, most_points_judged) + o.offset_floor_m * o.offset_floor_m;
      bool keep = std::abs(offset) <= cell_sigmas * std::sqrt(variance) + o.gate_slack_m;
      if (keep && cell.N >= 3.0) {
        const double freedom = cell.N - 1.0;
        keep = along(cell.scatter, u_) / freedom <=
               (column.variance + o.gate_slack_m * o.gate_slack_m) *
                   (1.0 + law_share + cell_thickness_sigmas * std::sqrt(2.0 / freedom));
      }
      changed |= keep != cell.kept;
      cell.kept = keep;
    }
    if (changed) sum_up(column);
    return changed;
  }

  // Decides for every column whether it lies on the plane (q_, u_); true when any changed its mind.
  bool judge() {
    const PlaneMapOptions& o = context_.options;
    const double slack2 = o.gate_slack_m * o.gate_slack_m;
    bool changed = false;
    for (const PatchRun& run : room_.runs) {
      const NoiseModel& noise = noise_of(run);
      for (Column& column : columns_of(run)) {
        // Seen from the sensor, in the directions of the world: it depends on lengths and angles only.
        column.variance = noise.variance_along(column.mean - run.T_G_sensor.t, u_);
        changed |= judge_cells(column);
        const double offset = u_.dot(column.mean - q_);
        const double allowed =
            o.gate_sigmas * std::sqrt(column.variance / column.N + o.offset_floor_m * o.offset_floor_m) +
            o.gate_slack_m;
        bool keep = column.N > 0.0 && std::abs(offset) <= allowed;
        if (keep && column.N >= 3.0) {
          const double thickness2 = along(column.scatter, u_) / column.N;
          // 1.69: thirty per cent thicker than the noise says is still the same surface.
          keep = thickness2 <= 1.69 * (column.variance + slack2) * (1.0 + 4.0 * std::sqrt(2.0 / column.N));
        }
        changed |= keep != column.kept;
        column.kept = keep;
      }
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
      scatter += w * column.scatter;
      add_square(w * column.N, column.mean - q, scatter);
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
    WeightedSum sum;
    for (const PatchRun& run : room_.runs) add_observation(run, feature, sum, kept_cells);
    return feature.observations.size() >= context_.options.min_patches && is_wide(sum);
  }

  // Of a strip that is met at a grazing angle the width may be noise along the ray and nothing else: it is then no
  // plane but a line, which holds no normal.
  [[nodiscard]] bool is_wide(const WeightedSum& sum) const {
    const Vector3d off = sum.moment / sum.N;
    Upper scatter = sum.square;
    add_square(-sum.N, off, scatter);
    return symmetric_eigen_fast(full(scatter)).values[1] >= least_true_share * seen_width2_ * sum.N;
  }

  // All sums are made in the world's directions, about the sensor: its cells need not be looked up again.
  void add_observation(const PatchRun& run, PlaneFeature& feature, WeightedSum& sum, std::size_t& kept_cells) const {
    const NoiseModel& noise = noise_of(run);
    const SE3& T_G_sensor = run.T_G_sensor;
    PlaneObservation o;
    o.stop = context_.patches[run.patch].stop;
    o.lidar = context_.patches[run.patch].lidar;
    double variance = 0.0;
    Vector3d mean = Vector3d::Zero();
    for (const Column& column : columns_of(run)) {
      if (!column.kept) continue;
      variance += column.N * column.variance;
      o.N += column.N;
      mean += column.N * column.mean;
      for_each_kept(column, [&](const GateCell&) { ++kept_cells; });
    }
    if (o.N < 1.0) return;
    mean /= o.N;
    variance /= o.N;
    Upper scatter = Upper::Zero();
    for_each_kept(run, [&](const GateCell& cell) {
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
    sum.N += o.weight * o.N;
    sum.moment += o.weight * o.N * (mean - q_);
    sum.square += o.weight * scatter;
    add_square(o.weight * o.N, mean - q_, sum.square);
    if (context_.options.with_rays) feature.rays.push_back(rays_of(run, noise, o.N, mean));
  }

  // A matrix in the directions of the world in those of the sensor.
  static Matrix3d in_sensor(const Matrix3d& M, const SE3& T_G_sensor) {
    return T_G_sensor.R.transpose() * M * T_G_sensor.R;
  }

  // The scatter of a cell that lies at `p` from the sensor, the noise's own share taken out. A covariance along and
  // across a ray turns with the ray.
  static Upper without_noise(const GateCell& cell, const Vector3d& p, const NoiseModel& noise) {
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

  // Within a cell the directions change with the points: d(p) = d + A (p - mean) / range with A = 1 - d d^T. With S its
  // scatter and s = S d, S A = S - s d^T and A S A = S - s d^T - d s^T + (d.s) d d^T.
  RayMoments rays_of(const PatchRun& run, const NoiseModel& noise, double N, const Vector3d& mean) const {
    const Vector3d& sensor = run.T_G_sensor.t;
    Vector3d direction = Vector3d::Zero();
    for_each_kept(run, [&](const GateCell& cell) { direction += cell.N * (cell.mean - sensor).normalized(); });
    direction /= N;
    RayMoments rays;
    Upper scatter = Upper::Zero();
    for_each_kept(run, [&](const GateCell& cell) {
      const Vector3d p = cell.mean - sensor;
      const double range = p.norm();
      const Vector3d d = p / range;
      const Upper upper = without_noise(cell, p, noise);
      const Matrix3d S = full(upper);
      const Vector3d s = S * d;
      const Vector3d turned = d - direction;
      rays.cross += (S - s * d.transpose()) / range + (cell.N * (cell.mean - mean)) * turned.transpose();
      // With e = (d.s) d / 2 - s it is S + e d^T + d e^T.
      const Vector3d e = 0.5 * d.dot(s) * d - s;
      Upper across;
      across << upper[0] + 2.0 * e[0] * d[0], upper[1] + e[0] * d[1] + d[0] * e[1],
          upper[2] + e[0] * d[2] + d[0] * e[2], upper[3] + 2.0 * e[1] * d[1], upper[4] + e[1] * d[2] + d[1] * e[2],
          upper[5] + 2.0 * e[2] * d[2];
      scatter += across / (range * range);
      add_square(cell.N, turned, scatter);
    });
    rays.mean = run.T_G_sensor.R.transpose() * direction;
    rays.cross = in_sensor(rays.cross, run.T_G_sensor);
    rays.scatter = in_sensor(full(scatter), run.T_G_sensor);
    return rays;
  }

  template <class F>
  void for_each_kept(const PatchRun& run, const F& f) const {
    for (const Column& column : columns_of(run)) {
      if (!column.kept) continue;
      for_each_kept(column, f);
    }
  }

  template <class F>
  void for_each_kept(const Column& column, const F& f) const {
    for (const GateCell& cell : cells_of(column)) {
      if (cell.kept) f(cell);
    }
  }

  std::span<const WorldCell> cells_;
  const GateContext& context_;
  GateRoom& room_;
  Vector3d q_ = Vector3d::Zero();
  Vector3d u_ = Vector3d::UnitZ();
  double seen_width2_ = 0.0;
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
