#include "core/voxel/plane_gate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/geometry/symmetric_eigen.h"
#include "core/voxel/gate_columns.h"

namespace rigcal {
namespace {

constexpr double gate_sigmas = 3.0;
constexpr double min_kept = 0.7;  // Below this share of points kept, a voxel is split.

// Of all observations of a plane, about a point of it, the noise's own share taken out.
struct WeightedSum {
  double N = 0.0;
  Vector3d moment = Vector3d::Zero();
  UpperTriangle square = UpperTriangle::Zero();
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
  Gate(std::span<const WorldCell> cells, const GateContext& context, GateColumns& columns)
      : cells_(cells), context_(context), columns_(columns) {}

  PlaneVerdict run(const CellTotal& total, PlaneFeature& feature, std::size_t& kept_cells) {
    const PlaneMapOptions& o = context_.options;
    q_ = total.mean;
    const SymmetricEigen eigen = symmetric_eigen_fast(total.scatter);
    u_ = eigen.vectors.col(0);
    seen_width2_ = eigen.values[1] / total.N;
    columns_.make(cells_, context_, q_, u_);
    double kept_share = 0.0;
    double chi2 = 0.0;
    for (int round = 0; round < 4; ++round) {
      const bool changed = judge();
      if (!refit(total.N, kept_share, chi2)) return PlaneVerdict::split;
      if (!changed && round > 0) break;
    }
    if (kept_share < min_kept || chi2 > o.max_chi2) return PlaneVerdict::split;
    return collect(feature, kept_cells) ? PlaneVerdict::plane : PlaneVerdict::split;
  }

 private:
  [[nodiscard]] const NoiseModel& noise_of(const PatchColumns& patch) const {
    return context_.noise[static_cast<std::size_t>(context_.patches[patch.number].lidar)];
  }

  // How far a cell is off the plane at least. The shift of one of a few points beside a border is known in the mean
  // only: it counts as anywhere between where it is with it and without.
  [[nodiscard]] double nearest_offset(const GateCell& cell) const {
    const double without = u_.dot(cell.mean - q_);
    const double with = without + cell.put_back_m;
    return without * with <= 0.0 ? 0.0 : std::min(std::abs(without), std::abs(with));
  }

  // Leaves out cells of another surface that the column's mean and thickness hide: one of a few points, or one that
  // holds an edge. True when any changed its mind.
  bool judge_cells(GateColumn& column) {
    const PlaneMapOptions& o = context_.options;
    bool changed = false;
    for (GateCell& cell : columns_.cells_of(column)) {
      const double offset = nearest_offset(cell);
      const double variance =
          column.variance / std::min(cell.N, most_points_judged) + o.offset_floor_m * o.offset_floor_m;
      bool keep = offset <= cell_sigmas * std::sqrt(variance) + o.gate_slack_m;
      if (keep && cell.N >= 3.0) {
        const double freedom = cell.N - 1.0;
        keep = along(cell.scatter, u_) / freedom <=
               (column.variance + o.gate_slack_m * o.gate_slack_m) *
                   (1.0 + law_share + cell_thickness_sigmas * std::sqrt(2.0 / freedom));
      }
      changed |= keep != cell.kept;
      cell.kept = keep;
    }
    if (changed) columns_.sum_up(column);
    return changed;
  }

  // Decides for every column whether it lies on the plane (q_, u_); true when any changed its mind.
  bool judge() {
    const PlaneMapOptions& o = context_.options;
    const double slack2 = o.gate_slack_m * o.gate_slack_m;
    bool changed = false;
    for (const PatchColumns& patch : columns_.patches()) {
      const NoiseModel& noise = noise_of(patch);
      for (GateColumn& column : columns_.of(patch)) {
        // Seen from the sensor, in the directions of the world: it depends on lengths and angles only.
        column.variance = noise.variance_along(column.mean - patch.T_G_sensor.t, u_);
        changed |= judge_cells(column);
        const double offset = u_.dot(column.mean - q_);
        const double allowed =
            gate_sigmas * std::sqrt(column.variance / column.N + o.offset_floor_m * o.offset_floor_m) + o.gate_slack_m;
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
    for (const GateColumn& column : columns_.all()) {
      if (!column.kept) continue;
      const double w = column.N / column.variance;
      weight += w;
      points += column.N;
      q += w * column.mean;
    }
    kept_share = points / all_points;
    if (points < context_.options.min_points || kept_share < 0.5 * min_kept) return false;
    q /= weight;
    UpperTriangle scatter = UpperTriangle::Zero();
    for (const GateColumn& column : columns_.all()) {
      if (!column.kept) continue;
      const double w = 1.0 / column.variance;
      scatter += w * column.scatter;
      add_square(w * column.N, column.mean - q, scatter);
    }
    const SymmetricEigen eigen = symmetric_eigen_fast(full(scatter));
    q_ = q;
    // Its sense stays, which is that of what means were put back by.
    const Vector3d normal = eigen.vectors.col(0);
    u_ = normal.dot(u_) < 0.0 ? Vector3d(-normal) : normal;
    const double slack = context_.options.gate_slack_m;
    chi2 = eigen.values[0] / (points * (1.0 + slack * slack * weight / points));
    return true;
  }

  bool collect(PlaneFeature& feature, std::size_t& kept_cells) {
    feature.observations.clear();
    feature.rays.clear();
    feature.center_G = q_;
    feature.normal_G = u_;
    WeightedSum sum;
    for (const PatchColumns& patch : columns_.patches()) add_observation(patch, feature, sum, kept_cells);
    return feature.observations.size() >= context_.options.min_patches && is_wide(sum);
  }

  // Of a strip that is met at a grazing angle the width may be noise along the ray and nothing else: it is then no
  // plane but a line, which holds no normal.
  [[nodiscard]] bool is_wide(const WeightedSum& sum) const {
    const Vector3d off = sum.moment / sum.N;
    UpperTriangle scatter = sum.square;
    add_square(-sum.N, off, scatter);
    return symmetric_eigen_fast(full(scatter)).values[1] >= least_true_share * seen_width2_ * sum.N;
  }

  // All sums are made in the world's directions, about the sensor: its cells need not be looked up again.
  void add_observation(const PatchColumns& patch, PlaneFeature& feature, WeightedSum& sum, std::size_t& kept_cells) {
    const NoiseModel& noise = noise_of(patch);
    const SE3& T_G_sensor = patch.T_G_sensor;
    PlaneObservation o;
    o.stop = context_.patches[patch.number].stop;
    o.lidar = context_.patches[patch.number].lidar;
    double variance = 0.0;
    Vector3d mean = Vector3d::Zero();
    for (const GateColumn& column : columns_.of(patch)) {
      if (!column.kept) continue;
      variance += column.N * column.variance;
      o.N += column.N;
      columns_.for_each_kept(column, [&](const GateCell& cell) {
        mean += cell.N * cell.mean;
        ++kept_cells;
      });
    }
    if (o.N < 1.0) return;
    mean /= o.N;
    variance /= o.N;
    UpperTriangle scatter = UpperTriangle::Zero();
    columns_.for_each_kept(patch, [&](const GateCell& cell) {
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
    if (context_.options.with_rays) feature.rays.push_back(rays_of(patch, noise, o.N, mean));
  }

  // A matrix in the directions of the world in those of the sensor.
  static Matrix3d in_sensor(const Matrix3d& M, const SE3& T_G_sensor) {
    return T_G_sensor.R.transpose() * M * T_G_sensor.R;
  }

  // The scatter of a cell that lies at `p` from the sensor, the noise's own share taken out. A covariance along and
  // across a ray turns with the ray. Where borders sort points by their noise, less than that has to do with their
  // places on the plane; across the plane all of it is there but what went when the mean was put back.
  [[nodiscard]] UpperTriangle without_noise(const GateCell& cell, const Vector3d& p, const NoiseModel& noise) const {
    const double r2 = std::max(p.squaredNorm(), 1e-12);
    const double cos = std::abs(u_.dot(p)) / std::sqrt(r2);
    const double along = noise.range_variance(r2, cos);
    const double aside = noise.angle_rad * noise.angle_rad * r2;
    UpperTriangle out = cell.scatter;
    add_square(-cell.N * (cell.noise_share * along - aside) / r2, p, out);
    const double put_back = cell.noise_shift_per_m * cell.noise_shift_per_m * along;
    add_square(-cell.N * (1.0 - cell.noise_share - put_back) * along * cos * cos, u_, out);
    out[0] -= cell.N * aside;
    out[3] -= cell.N * aside;
    out[5] -= cell.N * aside;
    return out;
  }

  // Within a cell the directions change with the points: d(p) = d + A (p - mean) / range with A = 1 - d d^T. With S its
  // scatter and s = S d, S A = S - s d^T and A S A = S - s d^T - d s^T + (d.s) d d^T.
  RayMoments rays_of(const PatchColumns& patch, const NoiseModel& noise, double N, const Vector3d& mean) const {
    const Vector3d& sensor = patch.T_G_sensor.t;
    Vector3d direction = Vector3d::Zero();
    RayMoments rays;
    columns_.for_each_kept(patch, [&](const GateCell& cell) {
      direction += cell.N * (cell.mean - sensor).normalized();
      rays.darkness += cell.N * cell.darkness;
    });
    direction /= N;
    rays.darkness /= N;
    UpperTriangle scatter = UpperTriangle::Zero();
    columns_.for_each_kept(patch, [&](const GateCell& cell) {
      const Vector3d p = cell.mean - sensor;
      const double range = p.norm();
      const Vector3d d = p / range;
      const UpperTriangle upper = without_noise(cell, p, noise);
      const Matrix3d S = full(upper);
      const Vector3d s = S * d;
      const Vector3d turned = d - direction;
      rays.cross += (S - s * d.transpose()) / range + (cell.N * (cell.mean - mean)) * turned.transpose();
      // With e = (d.s) d / 2 - s it is S + e d^T + d e^T.
      const Vector3d e = 0.5 * d.dot(s) * d - s;
      UpperTriangle across;
      across << upper[0] + 2.0 * e[0] * d[0], upper[1] + e[0] * d[1] + d[0] * e[1],
          upper[2] + e[0] * d[2] + d[0] * e[2], upper[3] + 2.0 * e[1] * d[1], upper[4] + e[1] * d[2] + d[1] * e[2],
          upper[5] + 2.0 * e[2] * d[2];
      scatter += across / (range * range);
      add_square(cell.N, turned, scatter);
    });
    rays.mean = patch.T_G_sensor.R.transpose() * direction;
    rays.cross = in_sensor(rays.cross, patch.T_G_sensor);
    rays.scatter = in_sensor(full(scatter), patch.T_G_sensor);
    return rays;
  }

  std::span<const WorldCell> cells_;
  const GateContext& context_;
  GateColumns& columns_;
  Vector3d q_ = Vector3d::Zero();
  Vector3d u_ = Vector3d::UnitZ();
  double seen_width2_ = 0.0;
};

}  // namespace

CellTotal total_of(std::span<const WorldCell> cells) {
  CellTotal total;
  for (const WorldCell& cell : cells) {
    total.N += cell.N;
    total.mean += cell.N * cell.mean;
  }
  total.mean /= total.N;
  UpperTriangle sum = UpperTriangle::Zero();
  for (const WorldCell& cell : cells) {
    sum += cell.scatter;
    add_square(cell.N, cell.mean - total.mean, sum);
  }
  total.scatter = full(sum);
  return total;
}

PlaneVerdict gate_plane(std::span<const WorldCell> cells, const CellTotal& total, const GateContext& context,
                        PlaneFeature& feature, std::size_t& kept) {
  thread_local GateColumns columns;
  Gate gate(cells, context, columns);
  return gate.run(total, feature, kept);
}

}  // namespace rigcal
