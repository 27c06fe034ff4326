#include "core/camera/second_opinion.h"

#include <Eigen/Cholesky>

#include "core/camera/information.h"
#include "core/geometry/chi_square.h"

namespace rigcal {
namespace {

// From where on edges are weak.
constexpr double weak_sigma_m = 0.005;
constexpr double weak_halves_m = 0.01;

bool is_weak(const CameraEstimate& estimate) {
  return estimate.pose.covariance.bottomRightCorner<3, 3>().trace() > weak_sigma_m * weak_sigma_m ||
         estimate.halves_m > weak_halves_m;
}

}  // namespace

void ask_second_opinion(const CameraScene& scene, const CameraTask& camera, const CameraState& state,
                        const RunContext& context, CameraEstimate& estimate) {
  PoseEstimate& pose = estimate.pose;
  estimate.disagreement_chi2 = 0.0;
  estimate.information =
      refine_information(scene, camera, changed(camera.intrinsics, state), pose.T_base_camera, context);
  if (!estimate.information) return;
  const Vector6d apart = (pose.T_base_camera.inverse() * estimate.information->T_base_camera).log();
  const Eigen::LDLT<Matrix6d> both((pose.covariance + estimate.information->covariance).ldlt());
  estimate.disagreement_chi2 = apart.dot(both.solve(apart));
  if (!is_weak(estimate) || estimate.disagreement_chi2 > chi2_95_6) return;
  const Matrix6d gain = both.solve(pose.covariance).transpose();
  pose.T_base_camera = pose.T_base_camera * SE3::exp(gain * apart);
  const Matrix6d fused = pose.covariance - gain * pose.covariance;
  pose.covariance = 0.5 * (fused + fused.transpose());
}

}  // namespace rigcal
