#include "core/camera/camera_start.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/best_apart.h"
#include "core/base/parallel.h"
#include "core/camera/image_motion.h"
#include "core/camera/information.h"
#include "core/camera/information_chance.h"
#include "core/camera/information_cost.h"
#include "core/camera/information_images.h"

namespace rigcal {
namespace {

constexpr int sectors = 24;        // of the sweep, each with what may be in view from it
constexpr int steps_a_sector = 6;  // of 2.5 degrees
constexpr double turn_step_rad = 2.0 * pi / (sectors * steps_a_sector);
// The cost must be smooth over a step, and over what a camera's place moves things by.
constexpr double pixel_rad = to_rad(1.0);
constexpr std::size_t sightings_a_sector = 6'000;
constexpr std::size_t sector_occluders = 80'000;
constexpr double least_seen = 300.0;

// Places are tried at these distances from the axis, on the side that the images tell, and along it, metres.
constexpr std::array<double, 5> beside_m{0.0, 0.2, 0.4, 0.7, 1.0};
constexpr double usual_beside_m = 0.3;
constexpr std::array<double, 5> along_m{0.0, -0.3, 0.3, -0.7, 0.7};

constexpr std::size_t refined_starts = 6;
constexpr std::size_t wanted_starts = 3;
constexpr double starts_apart_rad = to_rad(8.0);
// How far off the best of the sweep may still be.
constexpr double start_sigma_m = 0.3;
constexpr double start_sigma_rad = to_rad(4.0);

struct Start {
  SE3 T_base_camera;
  double score = 0.0;
};

std::vector<Vector3d> places(const Vector3d& foot, const Vector3d& axis, const Vector3d& lever) {
  std::vector<Vector3d> out;
  for (const double along : along_m) {
    for (const double beside : beside_m) out.push_back(foot + along * axis + beside * lever);
  }
  return out;
}

class Sweep {
 public:
  Sweep(const CameraScene& scene, const CameraTask& camera)
      : scene_(scene), camera_(camera), model_(camera.intrinsics), codes_(surface_codes(scene.samples)) {
    const double focal_px = 0.5 * (camera.intrinsics.fx + camera.intrinsics.fy);
    const int halvings = std::clamp(static_cast<int>(std::lround(std::log2(focal_px * pixel_rad))), 0, 8);
    images_ = information_images(scene, camera, halvings, Shown::brightness);
  }

  // The best place of each step all round.
  [[nodiscard]] std::vector<Start> run(const RigTurn& turn, const CameraAxis& seen) const {
    const Vector3d& axis_base = turn.axis_base;
    const Vector3d& foot = turn.foot_base;
    const Matrix3d R_0 = turn_onto(seen.axis_camera, axis_base);
    std::vector<Start> out;
    for (int sector = 0; sector < sectors; ++sector) {
      const double middle = (sector + 0.5) * steps_a_sector * turn_step_rad;
      const Matrix3d R_middle = exp_so3(middle * axis_base) * R_0;
      const SE3 centre{R_middle, foot + usual_beside_m * (R_middle * seen.lever_camera)};
      const std::vector<Sighting> sightings = sightings_from(centre);
      if (sightings.empty()) continue;
      const InformationCost cost(model_, sightings, images_);
      const InformationChance chance(sightings);
      std::vector<Start> steps(static_cast<std::size_t>(steps_a_sector));
      parallel_for(steps.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const double angle = middle + (static_cast<double>(k) - 0.5 * (steps_a_sector - 1)) * turn_step_rad;
          const Matrix3d R = exp_so3(angle * axis_base) * R_0;
          steps[k] = best_place(cost, chance, R, places(foot, axis_base, R * seen.lever_camera));
        }
      });
      out.insert(out.end(), steps.begin(), steps.end());
    }
    return out;
  }

 private:
  [[nodiscard]] std::vector<Sighting> sightings_from(const SE3& centre) const {
    SightingOptions wanted;
    wanted.max_samples = sector_occluders;
    wanted.max_sightings = sightings_a_sector;
    wanted.silhouette_cells = 1;
    const CameraModel wide = widened(model_, 0.5 * steps_a_sector * turn_step_rad, 3.0);
    return find_sightings(scene_, codes_, camera_, wide, centre, wanted);
  }

  [[nodiscard]] static Start best_place(const InformationCost& cost, const InformationChance& chance, const Matrix3d& R,
                                        const std::vector<Vector3d>& tried) {
    Start best{{R, tried.front()}, -1.0};
    for (const Vector3d& t : tried) {
      const InformationCost::Value value = cost.value({R, t});
      if (value.seen < least_seen) continue;
      const double score = 1.0 - value.distance - chance.gain(value.seen);
      if (score > best.score) best = {{R, t}, score};
    }
    return best;
  }

  const CameraScene& scene_;
  const CameraTask& camera_;
  CameraModel model_;
  SurfaceCodes codes_;
  std::vector<SmoothImage> images_;
};

bool is_near(const Start& a, const Start& b) {
  return rotation_distance(a.T_base_camera.R, b.T_base_camera.R) < starts_apart_rad;
}

}  // namespace

CameraStarts find_camera_starts(const CameraScene& scene, const CameraTask& camera, const RunContext& context) {
  if (!scene.turn) return {{}, "the rig did not turn in place"};
  const std::vector<SeenTwice> pairs = match_images(scene, camera);
  if (pairs.empty()) {
    return {{}, "nothing was recognised in two of its images, or the rig did not turn by 4 to 50 degrees between them"};
  }
  const auto axis = find_camera_axis(pairs);
  if (!axis) return {{}, "too little was recognised in two of its images to tell how it was turned"};
  if (context.cancelled()) return {};
  std::vector<Start> swept = Sweep(scene, camera).run(*scene.turn, *axis);
  std::erase_if(swept, [](const Start& start) { return start.score < 0.0; });
  swept = best_apart(std::move(swept), refined_starts, is_near);
  CameraCalibrationOptions loose;
  loose.guess_sigma_m = start_sigma_m;
  loose.guess_sigma_rad = start_sigma_rad;
  std::vector<Start> refined;
  for (const Start& start : swept) {
    if (context.cancelled()) return {};
    const auto found = search_information(scene, camera, start.T_base_camera, loose, context);
    if (!found) continue;
    refined.push_back({found->best.T_base_camera, -found->best.distance});
  }
  if (refined.empty()) return {{}, "nothing in its images goes with the map, wherever it is thought to be"};
  CameraStarts out;
  for (const Start& start : best_apart(std::move(refined), wanted_starts, is_near))
    out.T_base_camera.push_back(start.T_base_camera);
  return out;
}

}  // namespace rigcal
