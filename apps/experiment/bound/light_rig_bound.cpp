#include "apps/experiment/bound/light_rig_bound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "apps/experiment/bound/surface_bound.h"
#include "core/base/parallel.h"
#include "simdata/rig/sim_rig.h"
#include "simdata/scene/ray_caster.h"

namespace rigcal::bound {
namespace {

constexpr double wire_step_m = 1e-3;
constexpr double most_sigmas = 5.0;
// Two normals, or a point and a plane, that differ by less are the same.
constexpr double same = 1e-6;

struct ScenePlane {
  Vector3d normal;  // of one sign
  Vector3d point;
};

// Neither along nor across anything that is built.
Vector3d of_one_sign(const Vector3d& normal) {
  return normal.dot(Vector3d(0.3612, 0.4811, 0.7988)) < 0.0 ? Vector3d(-normal) : normal;
}

struct SurfaceSeen {
  ScenePlane plane;
  bool curved = false;
  ShotSums sums = ShotSums::Zero();
};

// A surface, or a piece of one: its number, and the cube that the piece lies in.
using Piece = std::array<int, 4>;
using PatchSurfaces = std::map<Piece, SurfaceSeen>;

// The cubes' corners lie on nothing that is built.
Piece piece_of(int surface, const Vector3d& place, const SurfaceTrust& trust) {
  if (std::isinf(trust.piece_m)) return {surface, 0, 0, 0};
  const Eigen::Array3d cube = ((place - Vector3d(0.3719, 0.6127, 0.8331)) / trust.piece_m).array().floor();
  return {surface, static_cast<int>(cube[0]), static_cast<int>(cube[1]), static_cast<int>(cube[2])};
}

// What one patch saw of each surface.
PatchSurfaces look_up(const sim::RayCaster& caster, const sim::Scene& scene, const sim::SimulatedLidar& lidar,
                      const SE3& T_scene_sensor, const std::vector<Point>& points, const SurfaceTrust& trust) {
  PatchSurfaces out;
  const sim::RayCaster::People nobody;
  for (const Point& point : points) {
    const Vector3d measured(point.x, point.y, point.z);
    const double range = measured.norm();
    if (range <= 0.0) continue;
    SurfaceShot shot;
    const Vector3d direction = measured / range;
    const Vector3d ray = T_scene_sensor.R * direction;
    const auto hit = caster.cast(T_scene_sensor.t, ray, nobody, lidar.noise.max_range);
    if (!hit || !scene.materials[static_cast<std::size_t>(hit->material)].is_plain()) continue;
    const double cos_incidence = std::abs(hit->normal.dot(ray));
    const double range_sigma = lidar.noise.range_sigma_at(hit->range, cos_incidence);
    shot.point = hit->range * direction;
    shot.range_variance = range_sigma * range_sigma;
    shot.angle_variance = lidar.noise.angle_sigma_rad * lidar.noise.angle_sigma_rad;
    shot.rounding_variance = wire_step_m * wire_step_m / 12.0;
    const double off = (range - hit->range) * cos_incidence;
    const Vector3d normal = of_one_sign(hit->normal);
    shot.normal = T_scene_sensor.R.transpose() * normal;
    if (off * off > most_sigmas * most_sigmas * distance_variance(shot)) continue;
    const Vector3d place = T_scene_sensor.t + hit->range * ray;
    const auto [at, fresh] = out.try_emplace(piece_of(hit->surface, place, trust));
    SurfaceSeen& seen = at->second;
    if (fresh) seen.plane = {normal, place};
    seen.curved |= std::abs(normal.dot(seen.plane.normal)) < 1.0 - same;
    if (!seen.curved) add_shot(T_scene_sensor, shot, seen.sums);
  }
  return out;
}

bool is_same_plane(const ScenePlane& a, const ScenePlane& b) {
  return std::abs(a.normal.dot(b.normal)) > 1.0 - same && std::abs(a.normal.dot(b.point - a.point)) < same;
}

// A number for each piece; those in one plane, and in one cube, have the same; -1: it is curved.
std::map<Piece, int> number_planes(const std::vector<PatchSurfaces>& patches, std::vector<ScenePlane>& planes) {
  std::map<Piece, ScenePlane> pieces;
  std::map<int, ScenePlane> surfaces;
  std::set<int> curved;
  for (const PatchSurfaces& patch : patches) {
    for (const auto& [piece, seen] : patch) {
      const auto [at, fresh] = surfaces.emplace(piece[0], seen.plane);
      if (seen.curved || !is_same_plane(at->second, seen.plane)) curved.insert(piece[0]);
      pieces.emplace(piece, seen.plane);
    }
  }
  std::map<Piece, int> numbers;
  std::map<Piece, std::vector<int>> of_cube;  // the planes in each
  for (const auto& [piece, plane] : pieces) {
    if (curved.count(piece[0]) > 0) {
      numbers[piece] = -1;
      continue;
    }
    std::vector<int>& here = of_cube[{0, piece[1], piece[2], piece[3]}];
    const auto known = std::find_if(here.begin(), here.end(),
                                    [&](int k) { return is_same_plane(planes[static_cast<std::size_t>(k)], plane); });
    if (known == here.end()) {
      here.push_back(static_cast<int>(planes.size()));
      planes.push_back(plane);
      numbers[piece] = here.back();
    } else {
      numbers[piece] = *known;
    }
  }
  return numbers;
}

}  // namespace

std::vector<std::optional<Matrix6d>> bound_of_light_rig(const sim::Scene& scene, const sim::LightRig& light,
                                                        const SurfaceTrust& trust) {
  // The scene's frame does as well as that of the first stop: right perturbations do not know the world's.
  std::vector<SE3> T_scene_base;
  for (const SE3& T_G_base : light.T_G_base) T_scene_base.push_back(light.T_scene_G * T_G_base);
  const sim::RayCaster caster(scene);
  const std::size_t lidars = light.lidars.size();
  std::vector<PatchSurfaces> found(light.patches.size());
  parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const sim::SimulatedLidar& lidar = light.lidars[k % lidars];
      const SE3 T = T_scene_base[static_cast<std::size_t>(light.patches[k].stop)] * lidar.T_base_sensor;
      found[k] = look_up(caster, scene, lidar, T, light.patches[k].points, trust);
    }
  });
  std::vector<ScenePlane> planes;
  const std::map<Piece, int> numbers = number_planes(found, planes);

  std::vector<SE3> T_base_sensor;
  int base = 0;
  for (std::size_t i = 0; i < lidars; ++i) {
    T_base_sensor.push_back(light.lidars[i].T_base_sensor);
    if (light.lidars[i].sensor == light.rig.base) base = static_cast<int>(i);
  }
  SurfaceBound bound(T_base_sensor, T_scene_base, base);
  for (const ScenePlane& plane : planes) bound.add_plane(plane.normal, plane.point);
  for (std::size_t k = 0; k < found.size(); ++k) {
    const int lidar = static_cast<int>(k % lidars);
    for (const auto& [piece, seen] : found[k]) {
      const int plane = numbers.at(piece);
      if (plane < 0) continue;
      bound.add(lidar, light.patches[k].stop, plane, seen.sums);
    }
  }
  return bound.covariances();
}

}  // namespace rigcal::bound
