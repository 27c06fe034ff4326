#include "apps/experiment/board_rivals.h"

#include <Eigen/Dense>
#include <algorithm>
#include <opencv2/calib3d.hpp>

#include "core/board/closed_form.h"
#include "core/geometry/matrix6.h"
#include "core/geometry/point_cluster.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

constexpr std::size_t least_on_edge = 3;
constexpr int line_steps = 10;

struct Both {
  const BoardSighting* first = nullptr;
  const BoardSighting* second = nullptr;
};

std::vector<Both> pairs_of(const std::vector<BoardPlace>& boards) {
  std::vector<Both> out;
  for (const BoardPlace& place : boards) {
    Both both;
    for (const BoardSighting& s : place.sightings) (s.sensor == 0 ? both.first : both.second) = &s;
    if (both.first != nullptr && both.second != nullptr) out.push_back(both);
  }
  return out;
}

std::optional<ClosedForm> closed_form_of(const std::vector<BoardPlace>& boards, const BoardModel& board) {
  std::vector<BoardPair> pairs;
  for (const Both& both : pairs_of(boards)) {
    pairs.push_back({board_side(both.first->T_sensor_board, board.plate_corners()),
                     board_side(both.second->T_sensor_board, board.plate_corners())});
  }
  return closed_form(pairs);
}

// Points of a LiDAR that lie where `across` times them says nothing, of the camera's plane or line.
struct Constraint {
  std::vector<Vector3d> points;  // LiDAR
  Vector3d on_it;                // camera, as all below
  Matrix3d across;               // n n^T of a plane, I - d d^T of a line
  Vector3d direction;            // n, or d,
  Vector3d direction_lidar;      // and what the LiDAR has for it.
};

std::optional<Constraint> line_of(const Both& both, const BoardModel& board, int axis, int sign) {
  Constraint out;
  PointCluster cluster;
  for (const BorderPoint& b : both.first->cloud->border) {
    if (b.axis != axis || b.sign != sign) continue;
    out.points.push_back(b.p);
    cluster.add(b.p);
  }
  if (out.points.size() < least_on_edge) return std::nullopt;
  const SE3& T = both.second->T_sensor_board;
  Vector3d middle = Vector3d::Zero();
  middle[axis] = 0.5 * sign * board.size()[axis];
  out.on_it = T * middle;
  out.direction = T.R.col(1 - axis);
  out.across = Matrix3d::Identity() - out.direction * out.direction.transpose();
  const Vector3d along = symmetric_eigen(cluster.covariance()).vectors.col(2);
  const double same = along.dot(both.first->T_sensor_board.R.col(1 - axis));
  out.direction_lidar = same < 0.0 ? Vector3d(-along) : along;
  return out;
}

std::vector<Constraint> constraints_of(const std::vector<BoardPlace>& boards, const BoardModel& board) {
  std::vector<Constraint> out;
  for (const Both& both : pairs_of(boards)) {
    if (!both.first->cloud || !both.second->image) continue;
    const SE3& T = both.second->T_sensor_board;
    const Vector3d n = T.R.col(2);
    out.push_back({both.first->cloud->points, T.t, n * n.transpose(), n, both.first->T_sensor_board.R.col(2)});
    for (int axis = 0; axis < 2; ++axis) {
      for (const int sign : {-1, 1}) {
        if (auto line = line_of(both, board, axis, sign)) out.push_back(std::move(*line));
      }
    }
  }
  return out;
}

// Mean squared distances of each plane and each line as one residual: Gauss-Newton on T_camera_lidar.
bool refine(const std::vector<Constraint>& constraints, SE3& T) {
  for (int step = 0; step < line_steps; ++step) {
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    for (const Constraint& c : constraints) {
      const double weight = 1.0 / static_cast<double>(c.points.size());
      for (const Vector3d& p : c.points) {
        Eigen::Matrix<double, 3, 6> J;
        J << -T.R * skew(p), T.R;
        H += weight * J.transpose() * c.across * J;
        g += weight * J.transpose() * c.across * (T * p - c.on_it);
      }
    }
    const Vector6d move = -solve_symmetric6(H, g);
    if (!move.allFinite()) return false;
    T = T * SE3{exp_so3(move.head<3>()), move.tail<3>()};
    if (move.norm() < 1e-10) break;
  }
  return true;
}

}  // namespace

std::optional<SE3> place_as_published(const std::vector<BoardPlace>& boards, const BoardModel& board) {
  const auto found = closed_form_of(boards, board);
  return found ? std::optional(found->T_a_b) : std::nullopt;
}

std::optional<SE3> place_by_planes(const std::vector<BoardPlace>& boards, const BoardModel& board) {
  const auto found = closed_form_of(boards, board);
  return found ? found->by_planes : std::nullopt;
}

std::optional<SE3> place_by_lines_and_planes(const std::vector<BoardPlace>& boards, const BoardModel& board) {
  const std::vector<Constraint> constraints = constraints_of(boards, board);
  if (constraints.size() < 3) return std::nullopt;
  Matrix3d turns = Matrix3d::Zero();
  for (const Constraint& c : constraints) turns += c.direction * c.direction_lidar.transpose();
  SE3 T_camera_lidar;
  T_camera_lidar.R = nearest_rotation(turns);
  Matrix3d A = Matrix3d::Zero();
  Vector3d y = Vector3d::Zero();
  for (const Constraint& c : constraints) {
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : c.points) mean += p / static_cast<double>(c.points.size());
    A += c.across;
    y += c.across * (c.on_it - T_camera_lidar.R * mean);
  }
  T_camera_lidar.t = A.ldlt().solve(y);
  if (!T_camera_lidar.t.allFinite() || !refine(constraints, T_camera_lidar)) return std::nullopt;
  return T_camera_lidar.inverse();
}

std::optional<SE3> place_by_all_corners(const std::vector<BoardPlace>& boards, const BoardModel& board,
                                        const CameraIntrinsics& camera_0, const CameraIntrinsics& camera_1) {
  std::vector<std::vector<cv::Point3f>> corners;
  std::vector<std::vector<cv::Point2f>> pixels[2];
  for (const Both& both : pairs_of(boards)) {
    if (!both.first->image || !both.second->image) continue;
    const std::vector<int>& ids = both.first->image->ids;
    const std::vector<int>& others = both.second->image->ids;
    std::vector<cv::Point3f> on_board;
    std::vector<cv::Point2f> in_image[2];
    for (std::size_t k = 0; k < ids.size(); ++k) {
      const auto other = std::find(others.begin(), others.end(), ids[k]);
      if (ids[k] < 0 || other == others.end()) continue;
      const Vector3d p = board.corner(ids[k]);
      const Eigen::Vector2d& a = both.first->image->pixels[k];
      const Eigen::Vector2d& b = both.second->image->pixels[static_cast<std::size_t>(other - others.begin())];
      on_board.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
      in_image[0].emplace_back(static_cast<float>(a.x()), static_cast<float>(a.y()));
      in_image[1].emplace_back(static_cast<float>(b.x()), static_cast<float>(b.y()));
    }
    if (on_board.size() < 6) continue;
    corners.push_back(std::move(on_board));
    for (int c = 0; c < 2; ++c) pixels[c].push_back(std::move(in_image[c]));
  }
  if (corners.empty()) return std::nullopt;
  const auto matrix = [](const CameraIntrinsics& k) {
    return cv::Mat(cv::Matx33d(k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0));
  };
  const auto distortion = [](const CameraIntrinsics& k) { return cv::Mat(k.distortion, true); };
  cv::Mat K[2] = {matrix(camera_0), matrix(camera_1)};
  cv::Mat D[2] = {distortion(camera_0), distortion(camera_1)};
  cv::Mat R;
  cv::Mat t;
  cv::Mat E;
  cv::Mat F;
  try {
    cv::stereoCalibrate(corners, pixels[0], pixels[1], K[0], D[0], K[1], D[1], {camera_0.width, camera_0.height}, R, t,
                        E, F, cv::CALIB_FIX_INTRINSIC);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  SE3 T_1_0;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) T_1_0.R(row, column) = R.at<double>(row, column);
    T_1_0.t[row] = t.at<double>(row);
  }
  return T_1_0.inverse();
}

}  // namespace rigcal
