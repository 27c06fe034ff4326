#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "simdata/rig/random_rig.h"
#include "simdata/scene/scene_file.h"
#include "tests/core/start/light_run.h"

namespace rigcal {

/// Four LiDARs mounted any way on a turntable, without a guess of where.
struct ThrownRig : LightRun {
  ThrownRig(const std::string& scene_name, std::uint64_t seed, int stops)
      : ThrownRig(*sim::load_scene(scene_name), seed, stops, sim::TurntableOptions{}) {}

  ThrownRig(const sim::Scene& scene, std::uint64_t seed, int stops, const sim::TurntableOptions& turntable)
      : LightRun(thrown(scene, seed, stops, turntable)) {}

  [[nodiscard]] std::vector<PatchSurfels> patches_of(int lidar) const {
    std::vector<PatchSurfels> out;
    for (const PatchSurfels& p : surfels) {
      if (p.lidar == lidar) out.push_back(p);
    }
    return out;
  }
  /// The table's axis as one LiDAR has it.
  [[nodiscard]] Vector3d axis_of(std::size_t lidar) const {
    return truth.T_base_sensor[lidar].R.transpose() * truth.axis;
  }

 private:
  static sim::LightRig thrown(const sim::Scene& scene, std::uint64_t seed, int stops,
                              const sim::TurntableOptions& turntable) {
    sim::LightRigOptions options;
    options.seed = seed;
    options.turntable = turntable;
    options.turntable.stops = stops;
    options.shots_per_patch = shots_per_patch;
    auto light = sim::make_random_rig(scene, options, {});
    EXPECT_TRUE(light.has_value());
    return *std::move(light);
  }
};

}  // namespace rigcal
