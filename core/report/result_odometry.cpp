// What the configurations of LiDAR odometry with cameras ask for.
#include <algorithm>

#include "core/base/text.h"
#include "core/report/matrix_text.h"
#include "core/report/result_writers.h"

namespace rigcal {
namespace {

/// Nine numbers, row by row.
std::string rows_text(const Matrix3d& R) {
  const Matrix3d by_columns = R.transpose();
  return list_text(Eigen::Map<const Eigen::VectorXd>(by_columns.data(), by_columns.size()));
}

}  // namespace

std::string fast_livo_yaml(const PlacedRig& rig) {
  const bool has_camera =
      std::any_of(rig.sensors.begin(), rig.sensors.end(), [](const PlacedSensor& sensor) { return sensor.is_camera; });
  std::string text = "# A block for each LiDAR, in it one for each camera. Metres; rotations row by row.\n";
  text += "# p_base = extrinsic_R p_lidar + extrinsic_T, the base being " + rig.base + ".\n";
  text += "# FAST-LIVO wants them from the LiDAR to its IMU: they are that only where the IMU's frame is the base's.\n";
  text += has_camera ? "# p_camera = Rcl p_lidar + Pcl.\n"
                     : "# No sensor is known for a camera, so that all stand as LiDARs: export with --rig RIG.\n";
  for (const PlacedSensor& lidar : rig.sensors) {
    if (lidar.is_camera) continue;
    text += key_text(lidar.name) + ":\n  extrinsic_T: " + list_text(lidar.T_base_sensor.t) +
            "\n  extrinsic_R: " + rows_text(lidar.T_base_sensor.R) + "\n";
    for (const PlacedSensor& camera : rig.sensors) {
      if (!camera.is_camera) continue;
      const SE3 T_camera_lidar = camera.T_base_sensor.inverse() * lidar.T_base_sensor;
      text += "  " + key_text(camera.name) + ":\n    Rcl: " + rows_text(T_camera_lidar.R) +
              "\n    Pcl: " + list_text(T_camera_lidar.t) + "\n";
    }
  }
  return text;
}

}  // namespace rigcal
