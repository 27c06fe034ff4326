#include "core/report/html/field_of_view.h"

#include <cmath>

#include "core/rig/camera_model.h"

namespace rigcal {
namespace {

constexpr int steps_a_side = 8;

struct Angles {
  double across_deg = 0.0;  ///< In all.
  double up_deg = 0.0;
  bool round = false;
};

// Data sheets of Livox: Avia 70.4 x 77.2 (not repetitive), Mid-40 38.4 round, Mid-70 70.4 round, Horizon 81.7 x
// 25.1, Tele-15 14.5 x 16.2.
Angles angles_of(LidarModel model) {
  switch (model) {
    case LidarModel::livox_avia:
      return {70.4, 77.2, true};
    case LidarModel::livox_mid40:
      return {38.4, 38.4, true};
    case LidarModel::livox_mid70:
      return {70.4, 70.4, true};
    case LidarModel::livox_horizon:
      return {81.7, 25.1, false};
    case LidarModel::livox_tele15:
      return {14.5, 16.2, true};
    case LidarModel::other:
      break;
  }
  return {};
}

// Corners of a square from -1 to 1 and points between them, around it once.
std::vector<Eigen::Vector2d> square() {
  std::vector<Eigen::Vector2d> out;
  for (int side = 0; side < 4; ++side) {
    for (int k = 0; k < steps_a_side; ++k) {
      const double s = -1.0 + 2.0 * k / steps_a_side;
      const Eigen::Vector2d p = side == 0   ? Eigen::Vector2d(s, -1.0)
                                : side == 1 ? Eigen::Vector2d(1.0, s)
                                : side == 2 ? Eigen::Vector2d(-s, 1.0)
                                            : Eigen::Vector2d(-1.0, -s);
      out.push_back(p);
    }
  }
  return out;
}

}  // namespace

std::vector<Vector3d> field_of_view(const Sensor& sensor) {
  std::vector<Vector3d> out;
  if (sensor.camera && sensor.camera->intrinsics) {
    const CameraIntrinsics& camera = *sensor.camera->intrinsics;
    const CameraModel model(camera);
    for (const Eigen::Vector2d& p : square()) {
      const Eigen::Vector2d pixel(0.5 * (p.x() + 1.0) * (camera.width - 1), 0.5 * (p.y() + 1.0) * (camera.height - 1));
      if (const auto ray = model.ray(pixel)) out.push_back(*ray);
    }
  } else if (sensor.lidar) {
    const Angles angles = angles_of(sensor.lidar->model);
    if (angles.across_deg <= 0.0) return out;
    for (const Eigen::Vector2d& p : square()) {
      const Eigen::Vector2d q = angles.round ? p.normalized() : p;
      const double across = to_rad(0.5 * angles.across_deg) * q.x();
      const double up = to_rad(0.5 * angles.up_deg) * q.y();
      out.emplace_back(std::cos(up) * std::cos(across), std::cos(up) * std::sin(across), std::sin(up));
    }
  }
  return out;
}

}  // namespace rigcal
