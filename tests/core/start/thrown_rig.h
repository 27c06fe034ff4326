#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/start/rig_start.h"
#include "core/voxel/cells.h"
#include "simdata/random_rig.h"
#include "simdata/scene_file.h"

namespace rigcal {

/// Four LiDARs mounted any way on a turntable, without a guess of where.
struct ThrownRig {
  sim::LightRig truth;
  std::vector<PatchSurfels> surfels;
  StartInput input;

  ThrownRig(const std::string& scene_name, std::uint64_t seed, int stops)
      : ThrownRig(*sim::load_scene(scene_name), seed, stops, sim::TurntableOptions{}) {}

  ThrownRig(const sim::Scene& scene, std::uint64_t seed, int stops, const sim::TurntableOptions& turntable) {
    sim::LightRigOptions options;
    options.seed = seed;
    options.turntable = turntable;
    options.turntable.stops = stops;
    options.shots_per_patch = 6000;
    auto light = sim::make_random_rig(scene, options, {});
    EXPECT_TRUE(light.has_value());
    truth = *std::move(light);
    std::vector<PatchCells> cells;
    for (const Patch& patch : truth.patches) {
      CellBuilder builder(patch.sensor, patch.stop, CellOptions{});
      builder.add(patch.points);
      cells.push_back(builder.finish());
    }
    surfels = extract_surfels(cells, SurfelOptions{});
    input.stops = stops;
    input.lidars = static_cast<int>(truth.T_base_sensor.size());
    input.guess_T_base_sensor.resize(truth.T_base_sensor.size());
    input.guess_T_base_sensor[0] = SE3{};
  }

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
};

}  // namespace rigcal
