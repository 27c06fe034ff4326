#include "apps/experiment/targetless/motion_based.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "core/geometry/numeric_derivative.h"
#include "core/start/hand_eye.h"

namespace rigcal::targetless {
namespace {

constexpr int odometry_iterations = 12;
// Motions between poses so many apart, and how far each is believed.
constexpr std::size_t farthest_apart = 6;
constexpr double motion_sigma_rad = 0.003;
constexpr double motion_sigma_m = 0.02;
constexpr int refine_steps = 20;
constexpr int yaw_starts = 12;

cv::Mat matrix_of(const Matrix3d& R) {
  cv::Mat out(3, 3, CV_64F);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) out.at<double>(row, column) = R(row, column);
  }
  return out;
}

cv::Mat matrix_of(const Vector3d& t) {
  cv::Mat out(3, 1, CV_64F);
  for (int row = 0; row < 3; ++row) out.at<double>(row) = t[row];
  return out;
}

// By rotations first, which alone tell it only where the axes of the turns differ.
std::optional<SE3> closed_form(const std::vector<SE3>& T_world_base, const std::vector<SE3>& T_other_sensor) {
  std::vector<cv::Mat> R_gripper;
  std::vector<cv::Mat> t_gripper;
  std::vector<cv::Mat> R_target;
  std::vector<cv::Mat> t_target;
  for (std::size_t j = 0; j < T_world_base.size(); ++j) {
    const SE3 T_sensor_other = T_other_sensor[j].inverse();
    R_gripper.push_back(matrix_of(T_world_base[j].R));
    t_gripper.push_back(matrix_of(T_world_base[j].t));
    R_target.push_back(matrix_of(T_sensor_other.R));
    t_target.push_back(matrix_of(T_sensor_other.t));
  }
  cv::Mat R;
  cv::Mat t;
  try {
    cv::calibrateHandEye(R_gripper, t_gripper, R_target, t_target, R, t, cv::CALIB_HAND_EYE_PARK);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  SE3 out;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) out.R(row, column) = R.at<double>(row, column);
    out.t[row] = t.at<double>(row);
  }
  if (!out.R.allFinite() || !out.t.allFinite()) return std::nullopt;
  out.R = nearest_rotation(out.R);
  return out;
}

// The motions A of the base and B of the sensor between the same moments; A X = X B.
class Motions {
 public:
  Motions(const std::vector<SE3>& T_world_base, const std::vector<SE3>& T_other_sensor) {
    for (std::size_t j = 0; j < T_world_base.size(); ++j) {
      for (std::size_t k = j + 1; k < T_world_base.size() && k <= j + farthest_apart; ++k) {
        A_.push_back(T_world_base[j].inverse() * T_world_base[k]);
        B_.push_back(T_other_sensor[j].inverse() * T_other_sensor[k]);
      }
    }
  }

  // The axis that the base turned about most, and the sensor's for the same turns: what is left is a turn about it.
  [[nodiscard]] std::vector<SE3> starts() const {
    const Vector3d a = main_axis(A_);
    Vector3d b = Vector3d::Zero();
    for (std::size_t i = 0; i < A_.size(); ++i) b += log_so3(A_[i].R).dot(a) * log_so3(B_[i].R);
    if (b.norm() < 1e-9) return {SE3{}};
    const Matrix3d aligned = turn_onto(b, a);
    std::vector<SE3> out;
    for (int k = 0; k < yaw_starts; ++k) out.push_back({exp_so3(2.0 * pi * k / yaw_starts * a) * aligned, {0, 0, 0}});
    return out;
  }

  // Rotations and translations together (Levenberg and Marquardt), from and into X; the cost at the end.
  [[nodiscard]] double refine(SE3& X) const {
    double lambda = 1e-3;
    Eigen::VectorXd r = residuals(X);
    for (int step = 0; step < refine_steps; ++step) {
      const Eigen::MatrixXd J =
          numeric_jacobian([&](const Eigen::VectorXd& dx) { return residuals(X * SE3::exp(Vector6d(dx))); }, 6);
      Matrix6d H = J.transpose() * J;
      H.diagonal() *= 1.0 + lambda;
      H.diagonal().array() += 1e-9;
      const Vector6d dx = -H.ldlt().solve(J.transpose() * r);
      const SE3 moved = X * SE3::exp(dx);
      const Eigen::VectorXd there = residuals(moved);
      if (there.squaredNorm() < r.squaredNorm()) {
        X = moved;
        r = there;
        lambda = std::max(1e-9, 0.1 * lambda);
      } else {
        lambda *= 10.0;
      }
      if (dx.norm() < 1e-10) break;
    }
    return r.squaredNorm();
  }

 private:
  [[nodiscard]] Eigen::VectorXd residuals(const SE3& X) const {
    Eigen::VectorXd out(6 * static_cast<Eigen::Index>(A_.size()));
    for (std::size_t i = 0; i < A_.size(); ++i) {
      const SE3 apart = (X * B_[i]).inverse() * (A_[i] * X);
      out.segment<3>(6 * static_cast<Eigen::Index>(i)) = log_so3(apart.R) / motion_sigma_rad;
      out.segment<3>(6 * static_cast<Eigen::Index>(i) + 3) = apart.t / motion_sigma_m;
    }
    return out;
  }

  std::vector<SE3> A_;
  std::vector<SE3> B_;
};

// The LiDAR's own scans laid on each other.
std::vector<SE3> own_poses(PairwiseIcp& icp, int lidar, const std::vector<std::vector<SE3>>& rough,
                           const RunContext& context) {
  RigState state;
  state.T_G_base = rough[static_cast<std::size_t>(lidar)];
  state.T_base_sensor.assign(rough.size(), SE3{});
  IcpRunOptions options;
  options.base = lidar;
  options.pose_iterations = odometry_iterations;
  options.iterations = 0;
  run_icp(icp, options, context, state);
  return state.T_G_base;
}

}  // namespace

std::optional<SE3> hand_eye(const std::vector<SE3>& T_world_base, const std::vector<SE3>& T_other_sensor) {
  if (T_world_base.size() < 3 || T_world_base.size() != T_other_sensor.size()) return std::nullopt;
  const Motions motions(T_world_base, T_other_sensor);
  std::vector<SE3> starts = motions.starts();
  if (const auto closed = closed_form(T_world_base, T_other_sensor)) starts.push_back(*closed);
  std::optional<SE3> best;
  double least = std::numeric_limits<double>::infinity();
  for (const SE3& start : starts) {
    SE3 X = start;
    const double cost = motions.refine(X);
    if (!(cost < least)) continue;
    least = cost;
    best = X;
  }
  return best;
}

std::vector<std::optional<SE3>> place_by_motion(PairwiseIcp& icp, int base, const std::vector<std::vector<SE3>>& rough,
                                                const RunContext& context) {
  std::vector<std::optional<SE3>> out(rough.size());
  const std::vector<SE3> of_base = own_poses(icp, base, rough, context);
  for (std::size_t i = 0; i < rough.size(); ++i) {
    if (static_cast<int>(i) == base)
      out[i] = SE3{};
    else
      out[i] = hand_eye(of_base, own_poses(icp, static_cast<int>(i), rough, context));
  }
  return out;
}

}  // namespace rigcal::targetless
