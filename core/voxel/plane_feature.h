#pragma once

#include <vector>

#include "core/geometry/se3.h"

namespace rigcal {

/// What one LiDAR at one stop saw of one plane, in the sensor's frame.
struct PlaneObservation {
  int stop = 0;
  int lidar = 0;
  double N = 0.0;  ///< Points.
  Vector3d mean = Vector3d::Zero();
  Matrix3d scatter = Matrix3d::Zero();  ///< sum (p - mean)(p - mean)^T, the noise's own share taken out.
  double weight = 1.0;                  ///< Of each point in the cost, 1/m^2.
  double offset_variance = 0.0;         ///< Of the mean along the plane's normal, m^2: noise and what a plane is not.
};

/// One plane of the map and everybody who saw it.
struct PlaneFeature {
  std::vector<PlaneObservation> observations;
  Vector3d center_G = Vector3d::Zero();
  Vector3d normal_G = Vector3d::UnitZ();
  double size_m = 0.0;  ///< Edge of the voxel that holds it.
  bool merged = false;  ///< Made of several leaves (core/planes/merge_planes.h), not of points anew.
};

}  // namespace rigcal
