#pragma once

#include <vector>

#include "core/camera/camera_calibration.h"
#include "core/pipeline/lidar_result.h"
#include "core/quality/verdict.h"

namespace rigcal {

/// What surfaces are no planes by shifts their edges as it does the LiDARs that lie on them, so that a camera's sigma
/// is as much wider as a LiDAR's of as many stops.
void widen_by_unevenness(const std::vector<CameraView>& views, const LidarSolution& solution, PoseEstimate& camera);

/// A camera whose images come from stops in which no LiDAR saw anything rests on the user's poses of these stops as
/// they are. They may all err alike, which no image shows: their prior's variance goes into the camera's, by the share
/// of the images that they hold, and the camera is `weak`. Nothing where every stop with an image has a cloud, or where
/// the camera has failed.
void rest_on_given_stops(const std::vector<CameraView>& views, const LidarRecording& recording,
                         const LidarSolution& solution, PoseEstimate& camera, Verdict& verdict);

}  // namespace rigcal
