#include "core/report/html/field_of_view.h"

#include <cmath>

#include "core/rig/camera_model.h"

namespace rigcal {
namespace {

constexpr int steps_a_side = 8;

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
    const LidarField& field = facts_of(sensor.lidar->model).field;
    if (field.across_deg <= 0.0) return out;
    for (const Eigen::Vector2d& p : square()) {
      const Eigen::Vector2d q = field.is_round ? p.normalized() : p;
      const double across = to_rad(0.5 * field.across_deg) * q.x();
      const double up = to_rad(0.5 * field.upright_deg) * q.y();
      out.emplace_back(std::cos(up) * std::cos(across), std::cos(up) * std::sin(across), std::sin(up));
    }
  }
  return out;
}

}  // namespace rigcal
