#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/edges/lidar_edges.h"

namespace rigcal {

/// A piece of surface of the map that stands, about 5 cm wide, in the world.
struct MapSample {
  Eigen::Vector3f p_G = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal_G = Eigen::Vector3f::Zero();  ///< Unit, towards who saw it; zero: it lies on no plane.
  std::uint8_t reflectivity = 0;
  std::uint8_t lidar = 0;  ///< Who saw it.
};

/// Samples of the map that lie together, one after the other.
struct SampleBlock {
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();  ///< Of the ball that holds them, in the world,
  float radius_m = 0.0F;                             ///< and its radius.
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

/// The one axis about which a rig turned from stop to stop, in its own frame. A camera without a guess is looked for
/// around it.
struct RigTurn {
  Vector3d axis_base = Vector3d::UnitZ();  ///< Unit.
  Vector3d foot_base = Vector3d::Zero();   ///< A point of it, at the height of the LiDARs.
};

/// What the LiDAR calibration leaves for the cameras: poses and map stand, only cameras move.
struct CameraScene {
  std::vector<SE3> T_G_base;     ///< Pose of the rig at each stop.
  std::vector<char> stop_known;  ///< One for each stop; images of others are not used.
  /// Nothing where the rig did not turn in place.
  std::optional<RigTurn> turn;
  std::vector<LidarEdge> edges;
  std::vector<MapSample> samples;
  std::vector<SampleBlock> blocks;  ///< Of the samples; empty: they are not sorted, and each is looked at.
};

}  // namespace rigcal
