#include "apps/experiment/vehicle_experiment.h"

#include <Eigen/QR>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/corner/rig_placement.h"
#include "core/corner/three_planes.h"
#include "core/start/registration.h"
#include "simdata/scene/ray_caster.h"
#include "simdata/scene/scene_file.h"

namespace rigcal {
namespace {

constexpr int lidars = 3;
constexpr int drive_poses = 9;
constexpr double range_noise_m = 0.02;
constexpr double longest_range_m = 50.0;
constexpr std::array<const char*, 5> ways{"no refinement", "ICP refinement", "motion", "paper's cost", "planes"};

using Cloud = std::vector<Vector3d>;

SE3 from_deg(double roll, double pitch, double yaw, const Vector3d& t) {
  return {exp_so3(to_rad(yaw) * Vector3d::UnitZ()) * exp_so3(to_rad(pitch) * Vector3d::UnitY()) *
              exp_so3(to_rad(roll) * Vector3d::UnitX()),
          t};
}

// One on top, one on each side, as road vehicles have them.
const std::array<SE3, lidars>& mounting() {
  static const std::array<SE3, lidars> T{SE3{}, from_deg(4.0, 8.0, 35.0, {0.3, 0.6, -0.2}),
                                         from_deg(-5.0, 6.0, -40.0, {0.3, -0.6, -0.2})};
  return T;
}

// One turn of 16 beams, 2 degrees apart.
Cloud scan(const sim::RayCaster& caster, const SE3& T_G_sensor, Random& random) {
  constexpr int beams = 16;
  constexpr int steps = 900;
  Cloud cloud;
  const sim::RayCaster::People nobody;
  for (int step = 0; step < steps; ++step) {
    for (int beam = 0; beam < beams; ++beam) {
      const double azimuth = 2.0 * pi * step / steps;
      const double elevation = to_rad(2.0 * beam - 15.0);
      const Vector3d ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation));
      const auto hit = caster.cast(T_G_sensor.t, T_G_sensor.R * ray, nobody, longest_range_m);
      if (hit && hit->range > 1.0) cloud.push_back((hit->range + range_noise_m * random.normal()) * ray);
    }
  }
  return cloud;
}

std::vector<PlacedSurfel> surfels_of(const Cloud& cloud) {
  std::vector<PlacedSurfel> out;
  for (const Surfel& s : extract_surfels(plane_cloud(cloud).cells, SurfelOptions{}).surfels) {
    out.push_back({s.mean, s.normal, 0});
  }
  return out;
}

SE3 by_registration(const Cloud& a, const Cloud& b, const SE3& start) {
  const SurfelIndex index(surfels_of(a), 1.0);
  MovingSurfels moving{{SE3{}}, {}};
  for (const PlacedSurfel& s : surfels_of(b)) moving.items.push_back({0, s.mean, s.normal});
  return refine_registration(index, moving, start, 0.5, 0.06);
}

// Hand-eye: what each LiDAR's own odometry says of the same steps, A X = X B.
SE3 by_motion(const std::vector<SE3>& steps_a, const std::vector<SE3>& steps_b) {
  Matrix3d turns = Matrix3d::Zero();
  for (std::size_t k = 0; k < steps_a.size(); ++k) {
    turns += log_so3(steps_a[k].R) * log_so3(steps_b[k].R).transpose();
  }
  SE3 X;
  X.R = nearest_rotation(turns);
  const auto rows = static_cast<Eigen::Index>(3 * steps_a.size());
  Eigen::MatrixXd A(rows, 3);
  Eigen::VectorXd y(rows);
  for (std::size_t k = 0; k < steps_a.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(3 * k);
    A.block<3, 3>(row, 0) = steps_a[k].R - Matrix3d::Identity();
    y.segment<3>(row) = X.R * steps_b[k].t - steps_a[k].t;
  }
  X.t = A.colPivHouseholderQr().solve(y);
  return X;
}

struct Place {
  std::array<std::array<std::optional<SE3>, ways.size()>, lidars> found;
  VehicleMoment moment;
};

// The three common planes that face the most different ways, as the paper's closed form wants them. Which plane is
// which is told by `calibrate --method planes`: what is compared is what comes after.
struct BestCorner {
  SE3 T_a_b;
  std::vector<PlanePair> pairs;
};

std::optional<BestCorner> best_corner(const PlaneView& a, const PlaneView& b, const PairPlacement& placed) {
  std::vector<PlanePair> pairs = pairs_of(a.planes, b.planes, placed.matches, placed.T_a_b);
  for (PlanePair& pair : pairs) pair.weight_a = pair.weight_b = 1.0;
  std::array<std::size_t, 3> best{};
  double most = least_independence;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (std::size_t j = i + 1; j < pairs.size(); ++j) {
      for (std::size_t k = j + 1; k < pairs.size(); ++k) {
        const double free = independence(pairs[i].a.normal, pairs[j].a.normal, pairs[k].a.normal);
        if (free <= most) continue;
        most = free;
        best = {i, j, k};
      }
    }
  }
  if (best[2] == 0) return std::nullopt;
  BestCorner out;
  Corner of_a;
  Corner of_b;
  for (std::size_t k = 0; k < 3; ++k) {
    out.pairs.push_back(pairs[best[k]]);
    of_a.planes[k] = out.pairs[k].a;
    of_b.planes[k] = out.pairs[k].b;
  }
  const auto point_a = intersection(of_a.planes);
  const auto point_b = intersection(of_b.planes);
  if (!point_a || !point_b) return std::nullopt;
  of_a.point = *point_a;
  of_b.point = *point_b;
  out.T_a_b = corner_alignment(of_a, of_b);
  return out;
}

void compare_still(const std::array<Cloud, lidars>& clouds, Place& out) {
  RigViews views;
  views.stops.resize(1);
  for (const Cloud& cloud : clouds) {
    views.names.push_back("L" + std::to_string(views.names.size() + 1));
    views.stops[0].push_back(plane_view(plane_cloud(cloud)));
  }
  std::vector<std::optional<SE3>> guess(lidars);
  for (std::size_t i = 0; i < lidars; ++i) guess[i] = SE3{Matrix3d::Identity(), mounting()[i].t};
  const RigPlacement placed = place_rig(views, guess);
  for (std::size_t i = 1; i < lidars; ++i) {
    if (!placed.lidars[i].known) continue;
    out.found[i][4] = placed.state.T_base_sensor[i];
    const PairPlacement pair = place_pair(*views.stops[0][0], *views.stops[0][i], guess[i]);
    const auto corner = best_corner(*views.stops[0][0], *views.stops[0][i], pair);
    if (!corner) continue;
    out.found[i][0] = corner->T_a_b;
    out.found[i][1] = by_registration(clouds[0], clouds[i], corner->T_a_b);
    out.found[i][3] = align_planes(corner->pairs, corner->T_a_b).T_a_b;
  }
  out.moment = {clouds[0], clouds[1], *guess[1], placed.state.T_base_sensor[1]};
}

void compare_driven(const sim::RayCaster& caster, SE3 T_G_base, std::array<Cloud, lidars> before, Random& random,
                    Place& out) {
  std::array<std::vector<SE3>, lidars> steps;
  for (int k = 1; k < drive_poses; ++k) {
    // A drive that also pitches and rolls: on level ground motion tells no heights.
    const double turn = k % 4 < 2 ? 8.0 : -8.0;
    const SE3 step = from_deg(random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0), turn, {0.25, 0.0, 0.0});
    T_G_base = T_G_base * step;
    for (std::size_t i = 0; i < lidars; ++i) {
      Cloud cloud = scan(caster, T_G_base * mounting()[i], random);
      const SE3 predicted = mounting()[i].inverse() * step * mounting()[i];
      steps[i].push_back(by_registration(before[i], cloud, predicted));
      before[i] = std::move(cloud);
    }
  }
  for (std::size_t i = 1; i < lidars; ++i) out.found[i][2] = by_motion(steps[0], steps[i]);
}

Place visit(const sim::RayCaster& caster, std::uint64_t seed) {
  Random random(seed, 3);
  Place out;
  const double x = random.uniform(-3.0, 3.0);
  const double y = random.uniform(-3.0, 3.0);
  const SE3 T_G_base = from_deg(0.0, 0.0, random.uniform(-180.0, 180.0), {x, y, 1.9});
  std::array<Cloud, lidars> clouds;
  for (std::size_t i = 0; i < lidars; ++i) clouds[i] = scan(caster, T_G_base * mounting()[i], random);
  compare_still(clouds, out);
  compare_driven(caster, T_G_base, std::move(clouds), random, out);
  return out;
}

VehicleRow row_of(const std::vector<Place>& places, std::size_t lidar) {
  VehicleRow row{"L1-L" + std::to_string(lidar + 1), static_cast<int>(places.size()), {}};
  for (std::size_t w = 0; w < ways.size(); ++w) {
    std::vector<double> rotation;
    std::vector<double> translation;
    for (const Place& place : places) {
      if (!place.found[lidar][w]) continue;
      rotation.push_back(rotation_distance(place.found[lidar][w]->R, mounting()[lidar].R));
      translation.push_back((place.found[lidar][w]->t - mounting()[lidar].t).norm());
    }
    row.ways.push_back({ways[w], static_cast<int>(rotation.size()), median(rotation), median(translation)});
  }
  return row;
}

}  // namespace

Expected<VehicleExperiment> drive_vehicle(int places, std::uint64_t seed, const RunContext& context) {
  const Expected<sim::Scene> scene = sim::load_scene("courtyard");
  if (!scene) return scene.error();
  const sim::RayCaster caster(*scene);
  std::vector<Place> visited(static_cast<std::size_t>(places));
  context.reporter.progress("vehicle", -1.0);
  parallel_for(visited.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end && !context.cancelled(); ++k) visited[k] = visit(caster, seed + k);
  });
  if (context.cancelled()) return cancelled_error("stopped before the end");
  VehicleExperiment out;
  for (std::size_t i = 1; i < lidars; ++i) out.rows.push_back(row_of(visited, i));
  if (!visited.empty()) out.moment = visited.front().moment;
  return out;
}

}  // namespace rigcal
