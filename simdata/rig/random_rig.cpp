#include "simdata/rig/random_rig.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "core/geometry/symmetric_eigen.h"
#include "simdata/scene/random_vectors.h"
#include "simdata/scene/ray_caster.h"

namespace rigcal::sim {
namespace {

constexpr std::uint64_t thrown_stream = 700;
constexpr int shots_to_see = 60;      // at each stop
constexpr int shots_to_share = 2400;  // of a run

Matrix3d random_rotation(Random& random) {
  Eigen::Vector4d xyzw;
  for (int k = 0; k < 4; ++k) xyzw[k] = random.normal();
  return rotation_from_xyzw(xyzw);
}

SE3 draw_mounting(Random& random, double reach_m) {
  const Matrix3d R = random_rotation(random);
  const double distance = reach_m * random.uniform();
  return {R, distance * random_direction(random)};
}

// A place, to a metre, and the side that it is seen from.
using Spot = std::array<std::int64_t, 4>;

struct Seen {
  Spot spot;
  Vector3d normal;
};

Spot spot_of(const Vector3d& p, const Vector3d& normal) {
  Spot spot{};
  for (int k = 0; k < 3; ++k) spot[static_cast<std::size_t>(k)] = static_cast<std::int64_t>(std::floor(p[k]));
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  spot[3] = 2 * axis + (normal[axis] < 0.0 ? 1 : 0);
  return spot;
}

// What some shots at each stop, all over the scan, meet nearer than 60 m.
class View {
 public:
  View(const RayCaster& caster, const TurntableMotion& motion, const SimulatedLidar& lidar, const SE3& T_base_sensor,
       int shots)
      : shots_(shots * motion.stop_count()) {
    constexpr std::int64_t stride = 991;
    const RayCaster::People nobody;
    for (int k = 0; k < motion.stop_count(); ++k) {
      const SE3 T = motion.T_scene_base_at_stop(k) * T_base_sensor;
      for (int i = 0; i < shots; ++i) {
        const Vector3d ray = T.R * lidar.scanner.direction(i * stride);
        const auto hit = caster.cast(T.t, ray, nobody, 60.0);
        if (hit) seen_.push_back({spot_of(T.t + hit->range * ray, hit->normal), hit->normal});
      }
    }
  }

  [[nodiscard]] const std::vector<Seen>& seen() const { return seen_; }
  [[nodiscard]] bool has_all_directions() const {
    const auto all = [](const Spot&) { return true; };
    return static_cast<double>(seen_.size()) >= 0.4 * shots_ && least_share(all) >= 0.04;
  }
  [[nodiscard]] bool shares(const std::set<Spot>& known) const {
    return least_share([&](const Spot& spot) { return known.contains(spot); }) >= 0.03;
  }

 private:
  // Of the squares of the normals, along the direction that has least of them.
  template <class Takes>
  [[nodiscard]] double least_share(const Takes& takes) const {
    Matrix3d normals = Matrix3d::Zero();
    for (const Seen& s : seen_) {
      if (takes(s.spot)) normals += s.normal * s.normal.transpose();
    }
    return symmetric_eigen(normals).values[0] / static_cast<double>(std::max<std::size_t>(1, seen_.size()));
  }

  int shots_;
  std::vector<Seen> seen_;
};

// Where each LiDAR sits; nothing where one finds no place beside those before it.
std::optional<std::vector<SE3>> draw_mountings(const RayCaster& caster, const SimulatedRig& plan,
                                               const RandomMounting& mounting, Random& random) {
  constexpr int tries = 1000;
  std::vector<SE3> out;
  std::set<Spot> known;
  for (const SimulatedLidar& lidar : plan.lidars) {
    bool is_placed = false;
    for (int k = 0; k < tries && !is_placed; ++k) {
      const SE3 T = draw_mounting(random, mounting.reach_m);
      if (mounting.sees_all_directions && !View(caster, plan.motion, lidar, T, shots_to_see).has_all_directions())
        continue;
      if (mounting.shares_surfaces) {
        const View view(caster, plan.motion, lidar, T, shots_to_share / plan.motion.stop_count());
        if (!known.empty() && !view.shares(known)) continue;
        for (const Seen& s : view.seen()) known.insert(s.spot);
      }
      out.push_back(T);
      is_placed = true;
    }
    if (!is_placed) return std::nullopt;
  }
  return out;
}

}  // namespace

Expected<LightRig> make_random_rig(const Scene& scene, const LightRigOptions& options, const RandomMounting& mounting) {
  // What is carried round is a sensor that sees nothing; the LiDARs are mounted on it.
  Rig rig = nominal_rig();
  Sensor carrier;
  carrier.name = "carrier";
  carrier.camera.emplace();
  rig.sensors.insert(rig.sensors.begin(), carrier);
  rig.base = 0;
  rig.sensors[0].initial_T_base_sensor = SE3{};
  const auto plan = make_simulated_rig(rig, scene.T_scene_table, options.turntable, {}, options.seed);
  if (!plan) return plan.error();
  const RayCaster caster(scene);
  Random random(options.seed, thrown_stream);
  // Beside one that looks where nobody else can there is no place: then all are drawn anew.
  constexpr int most_rigs = 20;
  std::optional<std::vector<SE3>> mountings;
  for (int k = 0; k < most_rigs && !mountings; ++k) mountings = draw_mountings(caster, *plan, mounting, random);
  if (!mountings)
    return input_error("has no room for LiDARs that see all directions, as random rigs are asked to", scene.name,
                       "take another scene, or ask for less");
  for (std::size_t i = 0; i < mountings->size(); ++i)
    rig.sensors[static_cast<std::size_t>(plan->lidars[i].sensor)].initial_T_base_sensor = (*mountings)[i];
  LightRigOptions exact = options;
  exact.mount_error = {0.0, 0.0};
  Expected<LightRig> light = make_light_rig(scene, exact, rig);
  if (!light) return light;

  // Seen from the first LiDAR, and without the carrier.
  const SE3 T_base_carrier = light->T_base_sensor[1].inverse();
  light->T_base_sensor.erase(light->T_base_sensor.begin());
  for (SE3& T : light->T_base_sensor) T = T_base_carrier * T;
  light->T_base_sensor[0] = SE3{};
  for (SE3& T : light->T_G_base) T = T_base_carrier * T * T_base_carrier.inverse();
  light->T_scene_G = light->T_scene_G * T_base_carrier.inverse();
  for (Vector3d& step : light->step_rotations) step = T_base_carrier.R * step;
  light->axis = T_base_carrier.R * light->axis;
  light->axis_point = T_base_carrier * light->axis_point;
  light->axis_point -= light->axis_point.dot(light->axis) * light->axis;
  for (Patch& patch : light->patches) --patch.sensor;
  for (std::size_t i = 0; i < light->lidars.size(); ++i) {
    --light->lidars[i].sensor;
    light->lidars[i].T_base_sensor = light->T_base_sensor[i];
  }
  light->rig.sensors.erase(light->rig.sensors.begin());
  for (Sensor& sensor : light->rig.sensors) sensor.initial_T_base_sensor.reset();
  light->rig.sensors[0].initial_T_base_sensor = SE3{};
  return light;
}

}  // namespace rigcal::sim
