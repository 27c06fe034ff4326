#pragma once

#include <optional>

#include "core/edges/lidar_edges.h"
#include "core/rig/camera_model.h"

namespace rigcal {

/// What is estimated of a camera: its pose, and how its focal lengths, k1 and principal point depart from the rig file.
struct CameraState {
  SE3 T_base_camera;
  double focal_scale = 0.0;  ///< fx = (1 + focal_scale) times the rig file's, fy likewise.
  double k1_change = 0.0;
  Eigen::Vector2d principal_change_px = Eigen::Vector2d::Zero();  ///< Of cx and cy.
};

/// Order of its parameters: [rotation rad; translation m] in T exp(xi), focal scale, k1, cx, cy.
constexpr int pose_parameters = 6;
constexpr int lens_parameters = 4;
constexpr int camera_parameters = pose_parameters + lens_parameters;
using CameraVector = Eigen::Matrix<double, camera_parameters, 1>;
using CameraMatrix = Eigen::Matrix<double, camera_parameters, camera_parameters>;

[[nodiscard]] CameraState moved(const CameraState& state, const CameraVector& step);
[[nodiscard]] CameraIntrinsics changed(const CameraIntrinsics& intrinsics, const CameraState& state);

/// The camera of a state at one stop.
struct CameraAtStop {
  CameraModel model;  ///< With the state's intrinsics.
  SE3 T_C_G;
  double focal_scale = 0.0;
};

[[nodiscard]] CameraAtStop camera_at(const CameraModel& model, const CameraState& state, const SE3& T_G_base);

/// A point of a LiDAR edge as a camera sees it.
struct EdgeProjection {
  Eigen::Vector2d pixel;
  double range_m = 0.0;
  Eigen::Vector2d normal;  ///< Unit, across the projected edge.
  double sigma_px = 0.0;   ///< Of the pixel along the normal, by the edge's own uncertainty,
  double px_per_m = 0.0;   ///< and what an edge that lies off by a metre would do to it.
  Eigen::Matrix<double, 2, camera_parameters> jacobian;
  Eigen::Matrix<double, 2, 3> by_world;  ///< pixel / m, of the edge's place in the world.
};

/// Nothing where no ray reaches the point, or where the camera looks along the edge. With derivatives:
/// the residual n.(pixel - q) has the row n^T jacobian.
[[nodiscard]] std::optional<EdgeProjection> project_edge(const CameraAtStop& camera, const LidarEdge& edge);

}  // namespace rigcal
