#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <memory>
#include <type_traits>

#include "core/board/board_model.h"
#include "core/rig/camera_model.h"

namespace ceres {
class CostFunction;
}

/// Residuals of the joint adjustment for any scalar: double, or the dual numbers of Ceres. A pose is `start` times a
/// small motion x = [rotation; translation], so that derivatives at x = 0 are those of the right
/// perturbation of all results.
namespace rigcal::board {

template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

/// Rotation of p by the vector x[0 .. 2] (Rodrigues).
template <class T>
[[nodiscard]] Vector3<T> rotated(const T* x, const Vector3<T>& p) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const Vector3<T> phi(x[0], x[1], x[2]);
  const T angle2 = phi.dot(phi);
  if (angle2 < T(1e-24)) return p + phi.cross(p);
  const T angle = sqrt(angle2);
  const Vector3<T> axis = phi / angle;
  const T c = cos(angle);
  return p * c + axis.cross(p) * sin(angle) + axis * (axis.dot(p) * (T(1.0) - c));
}

/// start exp(x) p, to first order in x as the right perturbation.
template <class T>
[[nodiscard]] Vector3<T> moved(const SE3& start, const T* x, const Vector3<T>& p) {
  const Vector3<T> turned = rotated(x, p) + Vector3<T>(x[3], x[4], x[5]);
  return start.R.cast<T>() * turned + start.t.cast<T>();
}

/// The same for a direction.
template <class T>
[[nodiscard]] Vector3<T> turned(const SE3& start, const T* x, const Vector3<T>& direction) {
  return start.R.cast<T>() * rotated(x, direction);
}

/// The inverse of `moved`.
template <class T>
[[nodiscard]] Vector3<T> moved_back(const SE3& start, const T* x, const Vector3<T>& p) {
  const Vector3<T> local = start.R.transpose().cast<T>() * (p - start.t.cast<T>()) - Vector3<T>(x[3], x[4], x[5]);
  const T back[3] = {-x[0], -x[1], -x[2]};
  return rotated(back, local);
}

/// The pose at x.
[[nodiscard]] inline SE3 pose_at(const SE3& start, const double* x) {
  const Vector3d phi(x[0], x[1], x[2]);
  return {nearest_rotation(start.R * exp_so3(phi)), start.t + start.R * Vector3d(x[3], x[4], x[5])};
}

/// A camera whose intrinsics may change: rebuilt only when they did. For one thread.
class ChangingCamera {
 public:
  explicit ChangingCamera(const CameraIntrinsics& intrinsics) : intrinsics_(intrinsics), model_(intrinsics) {
    values_ = values_of(intrinsics);
  }
  [[nodiscard]] static std::array<double, intrinsics_count> values_of(const CameraIntrinsics& intrinsics);
  [[nodiscard]] static CameraIntrinsics with_values(CameraIntrinsics intrinsics, const double* values);
  /// The camera with fx fy cx cy d0 .. d4.
  [[nodiscard]] const CameraModel& at(const double* values) const;

 private:
  CameraIntrinsics intrinsics_;
  mutable std::array<double, intrinsics_count> values_{};
  mutable CameraModel model_;
};

/// A corner in an image over its noise: parameters camera, board, intrinsics; two residuals. A corner that the camera
/// cannot see under these parameters makes the step invalid. Derivatives by hand, as corners are most of the work.
struct CornerCost {
  const SE3* T_base_camera;
  const SE3* T_base_board;
  const ChangingCamera* camera;
  Vector3d corner;
  Eigen::Vector2d pixel;
  double sigma_px;

  /// False where the camera cannot see it. `jacobians` (rows by rows) or any of them may be null, as Ceres has it.
  bool evaluate(const double* const* parameters, double* residuals, double** jacobians) const;
};
/// For a solver that takes it over.
[[nodiscard]] ceres::CostFunction* corner_cost_function(const CornerCost& cost);

/// What a LiDAR's points on a board leave behind for their distances from its plane when all ranges are too long by an
/// unknown b: a point is p + b u, its distance n.p + d + b n.u = w.[p; 1; u] with w = [n; d; b n]. `root` is a
/// root of the sum of all [p; 1; u][p; 1; u]^T, so that the sum of squares is |root w|^2: seven residuals for any
/// number of points.
struct PlaneMoments7 {
  Eigen::Matrix<double, 7, 7> root = Eigen::Matrix<double, 7, 7>::Zero();
  double points = 0.0;
};
/// Of points in the LiDAR's frame.
[[nodiscard]] PlaneMoments7 plane_moments(const std::vector<Vector3d>& points);

/// The points of a LiDAR on a board over their noise: parameters LiDAR, board, range offset; seven residuals.
struct PlaneCost {
  const SE3* T_base_lidar;
  const SE3* T_base_board;
  const PlaneMoments7* moments;
  double sigma_m;

  template <class T>
  bool operator()(const T* lidar_x, const T* board_x, const T* range_offset, T* residual) const {
    const Vector3<T> normal_in_base = turned<T>(*T_base_board, board_x, Vector3<T>(T(0.0), T(0.0), T(1.0)));
    const Vector3<T> origin_in_base = moved<T>(*T_base_board, board_x, Vector3<T>(T(0.0), T(0.0), T(0.0)));
    const T back[3] = {-lidar_x[0], -lidar_x[1], -lidar_x[2]};
    const Vector3<T> in_start = T_base_lidar->R.transpose().cast<T>() * normal_in_base;
    const Vector3<T> n = rotated(back, in_start);
    const Vector3<T> origin = moved_back<T>(*T_base_lidar, lidar_x, origin_in_base);
    Eigen::Matrix<T, 7, 1> w;
    w << n, -n.dot(origin), range_offset[0] * n;
    for (int row = 0; row < 7; ++row) {
      T sum(0.0);
      for (int k = 0; k < 7; ++k) sum += moments->root(row, k) * w[k];
      residual[row] = sum / sigma_m;
    }
    return true;
  }
};

/// A point on the plate's border over its noise: parameters LiDAR, board, range offset, growth, widening. The plate
/// appears larger at each edge by half the beam and half a step of the scan: by `growth` at the distance `usual_range`,
/// and by `widening` for each metre farther.
struct BorderCost {
  const SE3* T_base_lidar;
  const SE3* T_base_board;
  Vector3d point;
  int axis;          ///< 0: an edge at +-x of the board, 1: at +-y.
  double sign;       ///< Which of the two.
  double half_size;  ///< Of the plate along that axis.
  double usual_range;
  double sigma_m;

  template <class T>
  bool operator()(const T* lidar_x, const T* board_x, const T* range_offset, const T* growth, const T* widening,
                  T* residual) const {
    const Vector3<T> p = point.cast<T>() + range_offset[0] * point.normalized().cast<T>();
    const Vector3<T> in_base = moved<T>(*T_base_lidar, lidar_x, p);
    const Vector3<T> on_board = moved_back<T>(*T_base_board, board_x, in_base);
    const T wider = growth[0] + widening[0] * (point.norm() - usual_range);
    residual[0] = (sign * on_board[axis] - half_size - wider) / sigma_m;
    return true;
  }
};

/// Where the pattern lies and how large it seems by the reflectivity of its squares, which are seen as directions:
/// parameters LiDAR, board; shift along both axes and turn about the normal on the plane of `T_lidar_pattern`
/// (SquareCue), distance by the size, each over its noise. Nothing that ranges are off by moves them.
struct SquaresCost {
  const SE3* T_base_lidar;
  const SE3* T_base_board;
  SE3 T_lidar_pattern;
  double sigma_m;
  double sigma_rad;
  double sigma_scale;

  template <class T>
  bool operator()(const T* lidar_x, const T* board_x, T* residual) const {
    const auto in_lidar = [&](const Vector3d& on_board) {
      const Vector3<T> in_base = moved<T>(*T_base_board, board_x, Vector3<T>(on_board.cast<T>()));
      return moved_back<T>(*T_base_lidar, lidar_x, in_base);
    };
    const Vector3d normal = T_lidar_pattern.R.col(2);
    const Vector3<T> origin = in_lidar(Vector3d::Zero());
    const Vector3<T> along = in_lidar(Vector3d::UnitX()) - origin;
    const T nearer = normal.dot(T_lidar_pattern.t) / normal.cast<T>().dot(origin);
    const Matrix3d to_board = T_lidar_pattern.R.transpose();
    const Vector3<T> off = to_board.cast<T>() * Vector3<T>(nearer * origin - T_lidar_pattern.t.cast<T>());
    residual[0] = off[0] / sigma_m;
    residual[1] = off[1] / sigma_m;
    residual[2] = (to_board.cast<T>() * along)[1] / sigma_rad;
    residual[3] = (nearer - 1.0) / sigma_scale;
    return true;
  }
};

}  // namespace rigcal::board
