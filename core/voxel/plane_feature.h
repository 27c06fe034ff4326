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

/// How an observation's points move where the ranges of its LiDAR change, by the unit directions d that they lie in.
struct RayMoments {
  Vector3d mean = Vector3d::Zero();     ///< Of d.
  Matrix3d cross = Matrix3d::Zero();    ///< sum (p - mean of p)(d - mean)^T, the noise's own share taken out.
  Matrix3d scatter = Matrix3d::Zero();  ///< sum (d - mean)(d - mean)^T
  double darkness = 0.0;                ///< Mean of the points' (Cell::darkness).
};

/// One plane of the map and everybody who saw it.
struct PlaneFeature {
  std::vector<PlaneObservation> observations;
  std::vector<RayMoments> rays;  ///< One for each observation where the map was asked for them; else empty.
  Vector3d center_G = Vector3d::Zero();
  Vector3d normal_G = Vector3d::UnitZ();
  double size_m = 0.0;        ///< Edge of the voxel that holds it.
  bool merged = false;        ///< Made of several leaves (core/planes/merge_planes.h), not of points anew.
  double merged_share = 0.0;  ///< Of a leaf: the share of its weight that a merged plane has taken over.
};

}  // namespace rigcal
