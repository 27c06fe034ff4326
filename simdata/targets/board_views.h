#pragma once

#include <vector>

#include "core/base/random.h"
#include "core/records/records.h"
#include "core/rig/rig.h"
#include "simdata/lidar/lidar_noise.h"
#include "simdata/lidar/prism_scanner.h"
#include "simdata/scene/ray_caster.h"
#include "simdata/scene/scene.h"

/// Checkerboards in scenes, and what sensors that stand still see of a scene: for what is simulated of the checkerboard
/// method.
namespace rigcal::sim {

/// How the two colours of a board answer a laser, and how much light they scatter.
struct BoardLook {
  double dark_reflectivity = 8.0;
  double bright_reflectivity = 75.0;
  float dark = 0.05F;
  float bright = 0.8F;
};

/// Puts a board into a scene: its squares, dark ones first as images have them (the square inwards of the first inner
/// corner is dark), the bright margin of the plate, and a stand behind it that reaches down to `ground_m`. The frame is
/// that of BoardSettings: origin in the middle of the plate, x along the columns, z away from who looks.
void add_board(Scene& scene, const SE3& T_scene_board, const BoardSettings& board, const BoardLook& look,
               double ground_m);

/// A spinning LiDAR: rings evenly apart, points evenly round each.
struct SpinningLidar {
  int rings = 16;
  double lowest_rad = to_rad(-15.0);
  double ring_step_rad = to_rad(2.0);
  double azimuth_step_rad = to_rad(0.2);
  LidarNoise noise = LidarNoise::none();
};

/// One turn of it, in the sensor's frame; the points carry their ring in Point::shot. Where the first point of the turn
/// lies is drawn.
[[nodiscard]] std::vector<Point> spin_once(const RayCaster& caster, const std::vector<Material>& materials,
                                           const SE3& T_scene_lidar, const SpinningLidar& lidar, Random& random);

/// What a Livox sensor accumulates over a stop of `seconds`: `shots` of those that it fires, spread evenly.
[[nodiscard]] std::vector<Point> stare(const RayCaster& caster, const std::vector<Material>& materials,
                                       const SE3& T_scene_lidar, const PrismScanner& scanner, const LidarNoise& noise,
                                       double seconds, int shots, Random& random);

}  // namespace rigcal::sim
