#include "core/camera/camera_state.h"

#include <cmath>

namespace rigcal {

CameraState moved(const CameraState& state, const CameraVector& step) {
  return {state.T_base_camera * SE3::exp(step.head<6>()), state.focal_scale + step[6], state.k1_change + step[7],
          state.principal_change_px + step.tail<2>()};
}

CameraIntrinsics changed(const CameraIntrinsics& intrinsics, const CameraState& state) {
  CameraIntrinsics out = intrinsics;
  out.fx *= 1.0 + state.focal_scale;
  out.fy *= 1.0 + state.focal_scale;
  if (!out.distortion.empty()) out.distortion[0] += state.k1_change;
  out.cx += state.principal_change_px.x();
  out.cy += state.principal_change_px.y();
  return out;
}

CameraAtStop camera_at(const CameraModel& model, const CameraState& state, const SE3& T_G_base) {
  return {model, (T_G_base * state.T_base_camera).inverse(), state.focal_scale};
}

std::optional<EdgeProjection> project_edge(const CameraAtStop& camera, const LidarEdge& edge) {
  // Along an edge that points at the camera pixels do not move, and there is no "across".
  constexpr double least_px_per_m = 1.0;
  const Vector3d p_C = camera.T_C_G * edge.p_G;
  PixelDerivatives derivatives;
  const auto pixel = camera.model.project(p_C, derivatives);
  if (!pixel) return std::nullopt;
  EdgeProjection out;
  out.by_world = derivatives.by_point * camera.T_C_G.R;
  const Eigen::Vector2d along = out.by_world * edge.direction_G;
  const double length = along.norm();
  if (!(length > least_px_per_m)) return std::nullopt;
  out.pixel = *pixel;
  out.range_m = p_C.norm();
  out.normal = {-along.y() / length, along.x() / length};
  const Vector3d across = out.by_world.transpose() * out.normal;
  out.sigma_px = std::sqrt(std::max(0.0, across.dot(edge.covariance_G * across)));
  out.px_per_m = across.norm();
  // p_C of T exp(xi) is exp(-xi) p_C.
  out.jacobian.leftCols<3>() = derivatives.by_point * skew(p_C);
  out.jacobian.middleCols<3>(3) = -derivatives.by_point;
  const CameraIntrinsics& in = camera.model.intrinsics();
  out.jacobian.col(6) = (derivatives.by_intrinsics.col(0) * in.fx + derivatives.by_intrinsics.col(1) * in.fy) /
                        (1.0 + camera.focal_scale);
  out.jacobian.col(7) = derivatives.by_intrinsics.col(4);
  out.jacobian.rightCols<2>().setIdentity();
  return out;
}

}  // namespace rigcal
