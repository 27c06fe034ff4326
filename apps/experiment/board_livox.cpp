#include "apps/experiment/board_livox.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/experiment/board_stage.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/board/board_adjustment.h"

namespace rigcal {
namespace {

constexpr double margin_px = 12.0;
constexpr double stop_s = 4.0;

struct Unit {
  LidarModel model;
  const char* name;
  double half_field_rad;  // within which a whole board is seen
  int shots;
};
constexpr std::array<Unit, 2> units{{{LidarModel::livox_mid40, "MID-40", to_rad(18.0), 150000},
                                     {LidarModel::livox_avia, "AVIA", to_rad(30.0), 400000}}};

struct LivoxRig {
  std::vector<BoardStation> stations;  ///< The LiDAR, the camera.
  sim::LidarNoise noise;
  sim::BoardLook look;
  double dark_farther_m = 0.0;  ///< Truth, head on.
};

LivoxRig draw_rig(const Unit& unit, Random& random) {
  LivoxRig out;
  out.stations = published_rig(random);
  out.stations = {out.stations[0], out.stations[2]};
  out.noise = sim::LidarNoise::of(unit.model);
  out.noise.range_sigma = random.uniform(0.005, 0.011);
  out.noise.range_sigma_per_m = 0.0;
  out.noise.second_ray_share = 1.0;
  const double sign = random.uniform() < 0.5 ? -1.0 : 1.0;
  const double apart = out.look.bright_reflectivity - out.look.dark_reflectivity;
  out.dark_farther_m = sign * random.uniform(0.001, 0.009);
  out.noise.dark_bias = out.dark_farther_m / (apart / 100.0);
  return out;
}

bool is_in_field(const Unit& unit, const BoardStation& lidar, const SE3& T_rig_board, const BoardModel& board) {
  const SE3 T = lidar.T_rig_sensor.inverse() * T_rig_board;
  for (const Vector3d& corner : board.plate_corners()) {
    const Vector3d p = T * corner;
    if (std::atan2(std::hypot(p.y(), p.z()), p.x()) > unit.half_field_rad) return false;
  }
  return true;
}

PoseRange range_of(const Unit& unit) {
  PoseRange range;
  range.near_m = 2.6;
  range.far_m = 4.5;
  range.bearing_rad = unit.half_field_rad;
  range.height_m = 0.5;
  return range;
}

struct Tried {
  std::optional<SE3> found;
  SE3 truth;
  double dark_truth_m = 0.0;
  double dark_found_m = 0.0;
  int boards = 0;
  std::vector<double> sides;
  std::vector<double> planes;
};

Tried calibrate(const LivoxRig& rig, const std::vector<BoardSighting>& sightings, const BoardModel& board) {
  Tried out;
  out.truth = rig.stations[0].T_rig_sensor.inverse() * rig.stations[1].T_rig_sensor;
  out.dark_truth_m = rig.dark_farther_m;
  double dark = 0.0;
  for (const BoardSighting& s : sightings) {
    if (!s.cloud) continue;
    ++out.boards;
    for (int axis = 0; axis < 2; ++axis) out.sides.push_back(2.0 * std::abs(s.cloud->growth_m[axis]));
    out.planes.push_back(s.cloud->plane_rms_m);
    if (!s.cloud->squares) continue;
    out.dark_found_m += s.cloud->squares->dark_farther_m;
    dark += 1.0;
  }
  out.dark_found_m /= std::max(1.0, dark);
  std::vector<BoardSensor> sensors(2);
  for (std::size_t s = 0; s < 2; ++s) {
    sensors[s].name = rig.stations[s].name;
    sensors[s].camera = rig.stations[s].camera;
  }
  sensors[0].fixed = true;
  const auto placed = place_pair(sightings, 0, 1, board, std::nullopt);
  if (!placed) return out;
  sensors[1].T_base_sensor = placed->T_a_b;
  const BoardAdjustment found = adjust_boards(sensors, board_places(sightings, sensors, board), board, {});
  if (found.converged && found.observable[1]) out.found = found.sensors[1].T_base_sensor;
  return out;
}

Tried try_rig(const Unit& unit, int poses, std::uint64_t seed, const RunContext& context) {
  Random random(seed, 51);
  const LivoxRig rig = draw_rig(unit, random);
  const BoardStage stage = bare_hall();
  const BoardSettings settings = published_board();
  const BoardModel board(settings);
  std::vector<BoardSighting> sightings;
  for (int pose = 0; pose < poses && !context.cancelled(); ++pose) {
    SE3 T = draw_board_pose(range_of(unit), random);
    while (!is_in_all_images(rig.stations, T, board, margin_px) || !is_in_field(unit, rig.stations[0], T, board)) {
      T = draw_board_pose(range_of(unit), random);
    }
    const std::uint64_t pose_seed = seed * 100 + static_cast<std::uint64_t>(pose);
    auto seen = see_board(stage, {rig.stations[1]}, T, settings, {published_noise(1)}, pose_seed)[0];
    for (BoardSighting& s : seen) s.sensor = 1;
    sim::Scene scene = stage.scene;
    sim::add_board(scene, stage.T_scene_rig * T, settings, rig.look, 0.0);
    const sim::RayCaster caster(scene);
    Random shots(pose_seed, 52);
    const auto scanner = sim::PrismScanner::of(unit.model, shots);
    const auto points = sim::stare(caster, scene.materials, stage.T_scene_rig * rig.stations[0].T_rig_sensor, *scanner,
                                   rig.noise, stop_s, unit.shots, shots);
    for (CloudBoard& b : find_cloud_boards(points, board, false).boards) {
      seen.push_back(cloud_sighting(0, 0, std::move(b), board));
    }
    for (BoardSighting& s : seen) {
      s.stop = pose;
      sightings.push_back(std::move(s));
    }
  }
  return calibrate(rig, sightings, board);
}

LivoxRow row_of(const Unit& unit, int poses, const std::vector<Tried>& tried) {
  LivoxRow row;
  row.model = unit.name;
  row.rigs = static_cast<int>(tried.size());
  std::vector<double> rotation;
  std::vector<double> translation;
  std::vector<double> sides;
  std::vector<double> planes;
  for (const Tried& t : tried) {
    row.shown += poses;
    row.found += t.boards;
    sides.insert(sides.end(), t.sides.begin(), t.sides.end());
    planes.insert(planes.end(), t.planes.begin(), t.planes.end());
    ++row.signs;
    row.signs_right += t.dark_found_m * t.dark_truth_m > 0.0 ? 1 : 0;
    if (!t.found) continue;
    ++row.answers;
    rotation.push_back(rotation_distance(t.found->R, t.truth.R));
    translation.push_back((t.found->t - t.truth.t).norm());
  }
  const auto most = [](const std::vector<double>& v) {
    return v.empty() ? 0.0 : *std::max_element(v.begin(), v.end());
  };
  const auto least = [](const std::vector<double>& v) {
    return v.empty() ? 0.0 : *std::min_element(v.begin(), v.end());
  };
  row.rotation_rad = median(rotation);
  row.translation_m = median(translation);
  row.worst_rotation_rad = most(rotation);
  row.worst_translation_m = most(translation);
  row.size_m = median(sides);
  row.worst_size_m = most(sides);
  row.plane_low_m = least(planes);
  row.plane_high_m = most(planes);
  return row;
}

}  // namespace

Expected<std::vector<LivoxRow>> try_livox_boards(const LivoxBoardOptions& options, const RunContext& context) {
  std::vector<LivoxRow> out;
  for (std::size_t u = 0; u < units.size(); ++u) {
    std::vector<Tried> tried(static_cast<std::size_t>(options.rigs));
    for (std::size_t k = 0; k < tried.size(); ++k) {
      const auto all = static_cast<double>(units.size() * tried.size());
      context.reporter.progress("livox", static_cast<double>(u * tried.size() + k) / all);
      tried[k] = try_rig(units[u], options.poses, options.seed + k, context);
      if (context.cancelled()) return cancelled_error("stopped before the end");
    }
    out.push_back(row_of(units[u], options.poses, tried));
  }
  return out;
}

}  // namespace rigcal
