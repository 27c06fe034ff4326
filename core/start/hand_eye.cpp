#include "core/start/hand_eye.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/best_apart.h"
#include "core/base/parallel.h"
#include "core/geometry/matrix6.h"
#include "core/geometry/spiral_direction.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/start/own_view.h"

namespace rigcal {
namespace {

// Rotations some ten degrees apart: directions of an axis of the sensor, and turns about it.
constexpr std::size_t directions = 400;
constexpr std::size_t twists = 36;
constexpr std::size_t searched_items = 1200;
// All are tried with every so many-th surfel, the best with all.
constexpr std::size_t first_stride = 5;
constexpr std::size_t searched_rotations = 400;
constexpr std::size_t peaks = 10;
constexpr double peak_apart_rad = to_rad(15.0);
constexpr std::size_t first_items = 1000;
constexpr std::size_t solved_items = 2500;
constexpr std::size_t least_of_patch = 20;
constexpr std::size_t finalists = 3;
constexpr std::size_t min_items = 40;
// Mountings that fit at least this well, compared with the best, are told; the same ones only once.
constexpr double contender_share = 0.75;
constexpr double same_rad = to_rad(5.0);
constexpr double same_m = 0.3;
// Stops that are turned by no more against each other look at the same.
constexpr double alike_rad = to_rad(40.0);
constexpr double damping = 1e-4;
constexpr double height_reach_m = 2.0;
constexpr double height_step_m = 0.1;
constexpr double height_apart_m = 0.3;
constexpr std::size_t heights_each = 3;
constexpr std::size_t height_items = 600;

struct Pair {
  std::size_t before;  // patches
  std::size_t after;
  SE3 moved;  // of the base, from the one to the other
};

// Each stop with the next one, and with the one besides that looks most the same way.
std::vector<Pair> pairs_of(const std::vector<PatchSurfels>& patches, const std::vector<SE3>& T_zero_base) {
  const auto pose = [&](std::size_t k) -> const SE3& { return T_zero_base[static_cast<std::size_t>(patches[k].stop)]; };
  std::vector<Pair> out;
  for (std::size_t k = 0; k < patches.size(); ++k) {
    if (k + 1 < patches.size()) out.push_back({k, k + 1, pose(k).inverse() * pose(k + 1)});
    std::size_t other = k;
    double least = alike_rad;
    for (std::size_t m = k + 2; m < patches.size(); ++m) {
      const double turned = rotation_distance(pose(k).R, pose(m).R);
      if (turned >= least) continue;
      least = turned;
      other = m;
    }
    if (other != k) out.push_back({k, other, pose(k).inverse() * pose(other)});
  }
  return out;
}

// Evenly over all rotations: directions on a spiral over the sphere, each with all twists about it.
Matrix3d rotation(std::size_t i) {
  const Vector3d direction = spiral_direction(i / twists, directions);
  const double twist = 2.0 * pi * static_cast<double>(i % twists) / static_cast<double>(twists);
  return turn_onto(Vector3d::UnitZ(), direction) * exp_so3(twist * Vector3d::UnitZ());
}

// Rotations for which stops agree best when the sensor is taken to stand in the base.
std::vector<Mounting> rotation_peaks(const std::vector<PatchSurfels>& patches, const std::vector<Pair>& pairs) {
  const std::vector<PatchSurfels> few = thinned(patches, searched_items, least_of_patch);
  std::vector<SurfelIndex> seen;
  for (const PatchSurfels& p : patches) seen.push_back(index_of(p, 1.0));
  const double cosine = std::cos(to_rad(26.0));
  const auto score = [&](const Matrix3d& R, std::size_t stride) {
    std::size_t matched = 0;
    std::size_t next = 0;
    for (const Pair& pair : pairs) {
      const Matrix3d R_moved = R.transpose() * pair.moved.R * R;
      const Vector3d t_moved = R.transpose() * pair.moved.t;
      const std::vector<Surfel>& surfels = few[pair.after].surfels;
      // Not the same few of each patch.
      for (std::size_t i = next++ % stride; i < surfels.size(); i += stride)
        matched +=
            seen[pair.before].contains(R_moved * surfels[i].mean + t_moved, R_moved * surfels[i].normal, cosine, 0.4)
                ? 1
                : 0;
    }
    return static_cast<double>(matched);
  };
  std::vector<Mounting> all(directions * twists);
  for (std::size_t i = 0; i < all.size(); ++i) all[i].T_base_sensor.R = rotation(i);
  for (const std::size_t stride : {first_stride, std::size_t{1}}) {
    parallel_for(all.size(), 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) all[i].score = score(all[i].T_base_sensor.R, stride);
    });
    std::stable_sort(all.begin(), all.end(), [](const Mounting& a, const Mounting& b) { return a.score > b.score; });
    all.resize(std::min(searched_rotations, all.size()));
  }
  return best_apart(std::move(all), peaks, [](const Mounting& a, const Mounting& b) {
    return rotation_distance(a.T_base_sensor.R, b.T_base_sensor.R) < peak_apart_rad;
  });
}

// One Gauss-Newton step for X: what was seen from stops turned by at most `turned_rad` is laid on each other.
SE3 mounting_step(const std::vector<PatchSurfels>& patches, const std::vector<SE3>& T_zero_base, double tolerance,
                  double turned_rad, const SE3& X) {
  std::vector<PlacedSurfel> placed;
  std::vector<Vector3d> means;
  std::vector<Matrix3d> R_zero_this;
  for (const PatchSurfels& p : patches) {
    const SE3 T = T_zero_base[static_cast<std::size_t>(p.stop)] * X;
    R_zero_this.push_back(T.R);
    for (const Surfel& s : p.surfels) {
      placed.push_back({T * s.mean, T.R * s.normal, static_cast<int>(R_zero_this.size()) - 1});
      means.push_back(s.mean);
    }
  }
  const std::size_t count = R_zero_this.size();
  std::vector<char> alike(count * count, 0);
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = 0; b < count; ++b)
      alike[a * count + b] = rotation_distance(R_zero_this[a], R_zero_this[b]) <= turned_rad ? 1 : 0;
  }
  const SurfelIndex index(placed, std::max(0.6, tolerance));
  const double min_cosine = std::cos(to_rad(std::min(24.0, 10.0 + 24.0 * tolerance)));
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  std::vector<int> partners;
  const auto row = [&](std::size_t i, const Vector3d& normal) {
    const Vector3d n = R_zero_this[static_cast<std::size_t>(placed[i].group)].transpose() * normal;
    Vector6d J;
    J << means[i].cross(n), n;
    return J;
  };
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const PlacedSurfel& a = placed[i];
    index.find_all(a.mean, a.normal, min_cosine, tolerance, a.group, 12, partners);
    for (const int partner : partners) {
      const auto k = static_cast<std::size_t>(partner);
      const PlacedSurfel& b = placed[k];
      if (!alike[static_cast<std::size_t>(a.group) * count + static_cast<std::size_t>(b.group)]) continue;
      const double r = b.normal.dot(a.mean - b.mean);
      const double w = 1.0 / (1.0 + 4.0 * r * r / (tolerance * tolerance));
      const Vector6d J = row(i, b.normal) - row(k, b.normal);
      H.noalias() += w * J * J.transpose();
      g.noalias() += w * r * J;
    }
  }
  H.diagonal().head<3>().array() += damping * H.diagonal().head<3>().mean() + 1e-9;
  H.diagonal().tail<3>().array() += damping * H.diagonal().tail<3>().mean() + 1e-9;
  const Vector6d dx = -solve_symmetric6(H, g);
  if (!dx.allFinite()) return X;
  SE3 moved = X * SE3::exp(dx);
  moved.R = nearest_rotation(moved.R);
  return moved;
}

struct Pass {
  double tolerance;
  double turned_rad;
  int repeats;
};

void refine_all(const std::vector<PatchSurfels>& patches, const std::vector<SE3>& T_zero_base,
                const std::vector<Pass>& passes, std::vector<Mounting>& mountings) {
  parallel_for(mountings.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      SE3& X = mountings[i].T_base_sensor;
      for (const Pass& pass : passes) {
        for (int k = 0; k < pass.repeats; ++k)
          X = mounting_step(patches, T_zero_base, pass.tolerance, pass.turned_rad, X);
      }
      std::vector<SE3> poses;
      for (const SE3& T : T_zero_base) poses.push_back(T * X);
      mountings[i].score = agreement(patches, poses);
    }
  });
  std::stable_sort(mountings.begin(), mountings.end(),
                   [](const Mounting& a, const Mounting& b) { return a.score > b.score; });
}

}  // namespace

std::vector<Mounting> find_mountings(const std::vector<PatchSurfels>& patches, const std::vector<SE3>& T_zero_base) {
  std::size_t items = 0;
  for (const PatchSurfels& p : patches) items += p.surfels.size();
  if (patches.size() < 2 || items < min_items) return {};
  std::vector<Mounting> contenders = rotation_peaks(patches, pairs_of(patches, T_zero_base));
  refine_all(thinned(patches, first_items, least_of_patch), T_zero_base, {{0.6, alike_rad, 5}, {0.35, to_rad(70.0), 5}},
             contenders);
  contenders.resize(std::min(finalists, contenders.size()));
  refine_all(thinned(patches, solved_items, least_of_patch), T_zero_base, {{0.25, pi, 4}, {0.1, pi, 4}}, contenders);
  const double least = contender_share * contenders.front().score;
  std::erase_if(contenders, [&](const Mounting& m) { return m.score < least; });
  return best_apart(std::move(contenders), finalists, [](const Mounting& a, const Mounting& b) {
    return rotation_distance(a.T_base_sensor.R, b.T_base_sensor.R) < same_rad &&
           (a.T_base_sensor.t - b.T_base_sensor.t).norm() < same_m;
  });
}

Vector3d main_axis(const std::vector<SE3>& T_zero_base) {
  Matrix3d sum = Matrix3d::Zero();
  for (const SE3& T : T_zero_base) {
    const Vector3d phi = log_so3(T.R);
    sum += phi * phi.transpose();
  }
  return symmetric_eigen(sum).vectors.col(2);
}

std::vector<SE3> mountings_on_map(const SurfelIndex& map, const MovingSurfels& moving,
                                  const std::vector<Mounting>& mountings, const Vector3d& axis) {
  const MovingSurfels few = thinned(moving, height_items);
  const double cosine = std::cos(to_rad(15.0));
  const auto steps = static_cast<int>(std::lround(height_reach_m / height_step_m));
  std::vector<SE3> out;
  for (const Mounting& m : mountings) {
    std::vector<Mounting> line;
    for (int k = -steps; k <= steps; ++k) {
      SE3 X = m.T_base_sensor;
      X.t += k * height_step_m * axis;
      line.push_back({X, balanced_score(map, few, X, cosine, 0.1)});
    }
    const auto is_near = [](const Mounting& a, const Mounting& b) {
      return (a.T_base_sensor.t - b.T_base_sensor.t).norm() < height_apart_m;
    };
    for (const Mounting& best : best_apart(std::move(line), heights_each, is_near)) out.push_back(best.T_base_sensor);
  }
  return out;
}

}  // namespace rigcal
