#include "core/pipeline/camera_trust.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/geometry/matrix6.h"
#include "core/pipeline/surface_trust.h"
#include "core/quality/verdict_text.h"

namespace rigcal {

void widen_by_unevenness(const std::vector<CameraView>& views, const LidarSolution& solution, PoseEstimate& camera) {
  std::set<int> stops;
  for (const CameraView& view : views) stops.insert(view.stop);
  camera.covariance = with_unevenness(camera.covariance, solution.unevenness_m, std::max<std::size_t>(1, stops.size()));
}

void rest_on_given_stops(const std::vector<CameraView>& views, const LidarRecording& recording,
                         const LidarSolution& solution, PoseEstimate& camera, Verdict& verdict) {
  if (verdict.status == Status::failed || !recording.trajectory_is_prior) return;
  std::vector<char> is_held(recording.stops.size(), 0);
  for (std::size_t k = 0; k < recording.patches.size(); ++k) {
    const PatchCells& patch = recording.patches[k];
    if (solution.use[k] && !patch.cells.empty()) is_held[static_cast<std::size_t>(patch.stop)] = 1;
  }
  Matrix6d of_poses = Matrix6d::Zero();
  double given = 0.0;
  for (const CameraView& view : views) {
    const auto stop = static_cast<std::size_t>(view.stop);
    if (is_held[stop] || !solution.adjust.stop_priors[stop]) continue;
    of_poses += inverse6(solution.adjust.stop_priors[stop]->information);
    given += 1.0;
  }
  if (given == 0.0) return;
  of_poses /= given;
  const double share = given / static_cast<double>(views.size());
  // The base's error at a stop as the camera has it.
  const Matrix6d to_camera = share * camera.T_base_camera.inverse().adjoint();
  camera.covariance += to_camera * of_poses * to_camera.transpose();
  weaken(verdict, number(given, 0) + " of its " + std::to_string(views.size()) +
                      (views.size() == 1 ? " images comes" : " images come") +
                      " from stops without a cloud, whose given poses were taken as they are (--pose-prior: " +
                      mm(std::sqrt(of_poses(3, 3))) + " and " + deg(std::sqrt(of_poses(0, 0))) +
                      "); record a cloud with each image");
}

}  // namespace rigcal
