#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <opencv2/calib3d.hpp>

#include "core/board/board_costs.h"
#include "core/board/board_images.h"

namespace rigcal {
namespace {

constexpr double least_forward = 0.05;  // cosine from the axis up to which a ray can stand on the plane z = 1

struct Rays {
  std::vector<cv::Point3d> corners;
  std::vector<cv::Point2d> places;
};

Rays rays_of(const ImageBoard& seen, const BoardModel& board, const CameraModel& camera) {
  Rays out;
  for (std::size_t k = 0; k < seen.ids.size(); ++k) {
    const auto ray = camera.ray(seen.pixels[k]);
    if (!ray || ray->z() < least_forward) continue;
    const Vector3d p = board.corner(seen.ids[k]);
    out.corners.emplace_back(p.x(), p.y(), p.z());
    out.places.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
  }
  return out;
}

std::vector<SE3> planar_poses(const Rays& rays) {
  std::vector<cv::Mat> turns;
  std::vector<cv::Mat> shifts;
  try {
    cv::solvePnPGeneric(rays.corners, rays.places, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turns, shifts, false,
                        cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    return {};
  }
  std::vector<SE3> out;
  for (std::size_t k = 0; k < turns.size(); ++k) {
    const Vector3d phi(turns[k].at<double>(0), turns[k].at<double>(1), turns[k].at<double>(2));
    const SE3 T{exp_so3(phi), {shifts[k].at<double>(0), shifts[k].at<double>(1), shifts[k].at<double>(2)}};
    if (T.t.allFinite() && T.R.allFinite() && T.t.z() > 0.0) out.push_back(T);
  }
  return out;
}

std::optional<ImagePose> refined(const SE3& start, const ImageBoard& seen, const BoardModel& board,
                                 const CameraModel& camera) {
  const board::ChangingCamera changing(camera.intrinsics());
  std::array<double, intrinsics_count> intrinsics = board::ChangingCamera::values_of(camera.intrinsics());
  const SE3 origin;
  double fixed[6] = {};
  double x[6] = {};
  ceres::Problem problem;
  for (std::size_t k = 0; k < seen.ids.size(); ++k) {
    auto* cost =
        board::corner_cost_function({&origin, &start, &changing, board.corner(seen.ids[k]), seen.pixels[k], 1.0});
    problem.AddResidualBlock(cost, nullptr, fixed, x, intrinsics.data());
  }
  problem.SetParameterBlockConstant(fixed);
  problem.SetParameterBlockConstant(intrinsics.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return std::nullopt;
  return ImagePose{board::pose_at(start, x),
                   std::sqrt(2.0 * summary.final_cost / static_cast<double>(seen.ids.size()))};
}

}  // namespace

std::optional<ImagePose> find_image_pose(const ImageBoard& seen, const BoardModel& board, const CameraModel& camera) {
  const Rays rays = rays_of(seen, board, camera);
  if (rays.corners.size() < 4) return std::nullopt;
  std::optional<ImagePose> best;
  for (const SE3& start : planar_poses(rays)) {
    const std::optional<ImagePose> pose = refined(start, seen, board, camera);
    if (pose && (!best || pose->rms_px < best->rms_px)) best = pose;
  }
  return best;
}

std::optional<CameraIntrinsics> rough_intrinsics(const std::vector<ImageBoard>& seen, const BoardModel& board,
                                                 DistortionModel model, int width, int height) {
  std::vector<std::vector<cv::Point3f>> corners;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const ImageBoard& one : seen) {
    if (!one.whole && !board.has_markers()) continue;
    auto& on_board = corners.emplace_back();
    auto& in_image = pixels.emplace_back();
    for (std::size_t k = 0; k < one.ids.size(); ++k) {
      const Vector3d p = board.corner(one.ids[k]);
      on_board.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
      in_image.emplace_back(static_cast<float>(one.pixels[k].x()), static_cast<float>(one.pixels[k].y()));
    }
  }
  if (corners.size() < 3) return std::nullopt;
  try {
    const cv::Mat K = cv::initCameraMatrix2D(corners, pixels, {width, height}, 1.0);
    CameraIntrinsics out{model,
                         width,
                         height,
                         K.at<double>(0, 0),
                         K.at<double>(1, 1),
                         K.at<double>(0, 2),
                         K.at<double>(1, 2),
                         std::vector<double>(distortion_count(model), 0.0)};
    const double size = std::max(width, height);
    if (!(out.fx > 0.1 * size) || !(out.fx < 50.0 * size) || !(out.fy > 0.0)) return std::nullopt;
    return out;
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
}

}  // namespace rigcal
