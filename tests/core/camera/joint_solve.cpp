#include "tests/core/camera/joint_solve.h"

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <memory>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

// A pose as Ceres keeps it: rotation by columns, then translation.
constexpr int pose_size = 12;
using PoseBlock = std::array<double, pose_size>;

PoseBlock block_of(const SE3& T) {
  PoseBlock block;
  Eigen::Map<Matrix3d>(block.data()) = T.R;
  Eigen::Map<Vector3d>(block.data() + 9) = T.t;
  return block;
}

SE3 pose_of(const double* block) { return {Eigen::Map<const Matrix3d>(block), Eigen::Map<const Vector3d>(block + 9)}; }

CameraState state_of(const double* pose, const double* lens) {
  return {pose_of(pose), lens[0], lens[1], {lens[2], lens[3]}};
}

#if CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1)
using CeresSteps = ceres::Manifold;
#else
using CeresSteps = ceres::LocalParameterization;
#endif

// Steps T exp(xi). Derivatives of cost functions by a pose stand in the first six of its twelve columns, so the
// derivative of the step is the identity above nothing. Before Ceres 2.1 (Ubuntu 22.04) the same things have other
// names.
class PoseSteps final : public CeresSteps {
 public:
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const PoseBlock block = block_of(pose_of(x) * SE3::exp(Eigen::Map<const Vector6d>(delta)));
    std::copy(block.begin(), block.end(), x_plus_delta);
    return true;
  }
#if CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1)
  [[nodiscard]] int AmbientSize() const override { return pose_size; }
  [[nodiscard]] int TangentSize() const override { return 6; }
  bool PlusJacobian(const double*, double* jacobian) const override { return identity(jacobian, pose_size, 6); }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Vector6d xi = (pose_of(x).inverse() * pose_of(y)).log();
    std::copy_n(xi.data(), 6, y_minus_x);
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override { return identity(jacobian, 6, pose_size); }
#else
  [[nodiscard]] int GlobalSize() const override { return pose_size; }
  [[nodiscard]] int LocalSize() const override { return 6; }
  bool ComputeJacobian(const double*, double* jacobian) const override { return identity(jacobian, pose_size, 6); }
#endif

 private:
  static bool identity(double* jacobian, int rows, int columns) {
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(jacobian, rows, columns)
        .setIdentity();
    return true;
  }
};

// What all costs share.
struct JointProblem {
  const CameraScene& scene;
  const CameraIntrinsics& intrinsics;
};

// The matches of one segment, each by its weight: residuals sqrt(w) n.(pi(K, D, T_C_G (X + shift)) - q), the shift
// being that of the whole line.
class SegmentCost final : public ceres::CostFunction {
 public:
  SegmentCost(const JointProblem& problem, int stop, std::vector<EdgeMatch> matches)
      : problem_(problem), stop_(stop), matches_(std::move(matches)) {
    set_num_residuals(static_cast<int>(matches_.size()));
    mutable_parameter_block_sizes()->assign({pose_size, lens_parameters, 3});
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const CameraState state = state_of(parameters[0], parameters[1]);
    const CameraModel model(changed(problem_.intrinsics, state));
    const CameraAtStop camera = camera_at(model, state, problem_.scene.T_G_base[static_cast<std::size_t>(stop_)]);
    for (std::size_t k = 0; k < matches_.size(); ++k) {
      const EdgeMatch& match = matches_[k];
      LidarEdge edge = problem_.scene.edges[match.sample];
      edge.p_G += Eigen::Map<const Vector3d>(parameters[2]);
      const auto projection = project_edge(camera, edge);
      if (!projection) return false;
      const double root = std::sqrt(match.weight);
      residuals[k] = root * match.normal.dot(projection->pixel - match.position);
      if (jacobians == nullptr) continue;
      const CameraVector row = root * (projection->jacobian.transpose() * match.normal);
      const Vector3d by_shift = root * (projection->by_world.transpose() * match.normal);
      if (jacobians[0] != nullptr) {
        double* by_pose = jacobians[0] + k * pose_size;
        std::fill_n(by_pose, pose_size, 0.0);
        std::copy_n(row.data(), 6, by_pose);
      }
      if (jacobians[1] != nullptr)
        std::copy_n(row.data() + pose_parameters, lens_parameters, jacobians[1] + lens_parameters * k);
      if (jacobians[2] != nullptr) std::copy_n(by_shift.data(), 3, jacobians[2] + 3 * k);
    }
    return true;
  }

 private:
  const JointProblem& problem_;
  int stop_;
  std::vector<EdgeMatch> matches_;
};

// A line is where it is said to be, to so much.
class ShiftCost final : public ceres::SizedCostFunction<3, 3> {
 public:
  explicit ShiftCost(double weight) : weight_(weight) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (int k = 0; k < 3; ++k) residuals[k] = weight_ * parameters[0][k];
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    for (int k = 0; k < 9; ++k) jacobians[0][k] = k % 4 == 0 ? weight_ : 0.0;
    return true;
  }

 private:
  double weight_;
};

// Where nothing else holds.
class PriorCost final : public ceres::SizedCostFunction<camera_parameters, pose_size, lens_parameters> {
 public:
  explicit PriorCost(const EdgePriors& priors) : priors_(priors) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const CameraState state = state_of(parameters[0], parameters[1]);
    const CameraVector weight = prior_sigma(priors_).array().inverse();
    Eigen::Map<CameraVector> out(residuals);
    out = weight.cwiseProduct(prior_offset(priors_, state));
    if (jacobians == nullptr) return true;
    // Offsets are small against a radian, and the prior is soft: the step's own derivative is good enough.
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, camera_parameters, pose_size, Eigen::RowMajor>> J(jacobians[0]);
      J.setZero();
      for (int k = 0; k < 6; ++k) J(k, k) = weight[k];
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, camera_parameters, lens_parameters, Eigen::RowMajor>> J(jacobians[1]);
      J.setZero();
      for (int k = 0; k < lens_parameters; ++k) J(pose_parameters + k, k) = weight[pose_parameters + k];
    }
    return true;
  }

 private:
  const EdgePriors& priors_;
};

struct Line {
  std::array<double, 3> shift{};
  double variance = 0.0;
  double segments = 0.0;
};

// A segment of one view, its matches with the weight that they have in the whole.
struct WeightedSegment {
  int stop = 0;
  int line = 0;
  double line_variance = 0.0;
  std::vector<EdgeMatch> matches;
};

std::vector<WeightedSegment> weighted_segments(const CameraScene& scene, const EdgeView& view,
                                               const CameraAtStop& camera, const MatchOptions& options) {
  std::vector<EdgeMatch> matches;
  std::vector<WeightedSegment> segments;
  const std::vector<SegmentFit> fits = match_view(scene, view, camera, options, &matches);
  auto match = matches.begin();
  for (std::size_t k = 0; k < fits.size(); ++k) {
    const SegmentFit& fit = fits[k];
    if (fit.samples == 0) continue;
    WeightedSegment segment{view.stop, fit.line, fit.line_variance, {}};
    // Matches come segment by segment, and the samples of a line by their numbers.
    const auto own =
        std::span(view.samples).subspan(view.segments[k].begin, view.segments[k].end - view.segments[k].begin);
    for (; match != matches.end() && std::binary_search(own.begin(), own.end(), match->sample); ++match) {
      match->weight *= view.weight * fit.information();
      // What weighs nothing would only cost time.
      if (match->weight > 1e-9) segment.matches.push_back(*match);
    }
    segments.push_back(std::move(segment));
  }
  return segments;
}

}  // namespace

JointSolution solve_jointly(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& start,
                            const EdgePriors& priors, const MatchOptions& options, std::span<const EdgeView> views) {
  const JointProblem shared{scene, intrinsics};
  PoseBlock pose = block_of(start.T_base_camera);
  std::array<double, lens_parameters> lens{start.focal_scale, start.k1_change, start.principal_change_px.x(),
                                           start.principal_change_px.y()};
  ceres::Problem problem;
  problem.AddParameterBlock(pose.data(), pose_size, new PoseSteps);
  problem.AddParameterBlock(lens.data(), lens_parameters);
  problem.AddResidualBlock(new PriorCost(priors), nullptr, pose.data(), lens.data());
  std::vector<std::vector<WeightedSegment>> segments(views.size());
  const CameraModel model(changed(intrinsics, start));
  parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const SE3& T_G_base = scene.T_G_base[static_cast<std::size_t>(views[k].stop)];
      segments[k] = weighted_segments(scene, views[k], camera_at(model, start, T_G_base), options);
    }
  });
  // Ceres orders what it eliminates by address: lines lie in one array in the order of their numbers, so that the same
  // sums come out each time.
  std::map<int, std::size_t> place_of;
  for (const std::vector<WeightedSegment>& of_view : segments) {
    for (const WeightedSegment& segment : of_view) place_of.emplace(segment.line, 0);
  }
  std::size_t places = 0;
  for (auto& [number, place] : place_of) place = places++;
  std::vector<Line> lines(places);
  for (std::vector<WeightedSegment>& of_view : segments) {
    for (WeightedSegment& segment : of_view) {
      Line& line = lines[place_of.at(segment.line)];
      line.variance += segment.line_variance;
      line.segments += 1.0;
      if (segment.matches.empty()) continue;
      problem.AddResidualBlock(new SegmentCost(shared, segment.stop, std::move(segment.matches)), nullptr, pose.data(),
                               lens.data(), line.shift.data());
    }
  }
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  ordering->AddElementToGroup(pose.data(), 1);
  ordering->AddElementToGroup(lens.data(), 1);
  for (Line& line : lines) {
    if (!problem.HasParameterBlock(line.shift.data())) continue;
    problem.AddResidualBlock(new ShiftCost(std::sqrt(line.segments / line.variance)), nullptr, line.shift.data());
    ordering->AddElementToGroup(line.shift.data(), 0);
  }
  ceres::Solver::Options solver;
  solver.num_threads = 1;
  // Lines do not depend on each other: their shifts are eliminated first.
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = 20;
  solver.function_tolerance = 1e-12;
  solver.parameter_tolerance = 1e-10;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  JointSolution out;
  out.converged = summary.termination_type == ceres::CONVERGENCE;
  out.iterations = static_cast<int>(summary.iterations.size());
  out.state = state_of(pose.data(), lens.data());
  out.state.T_base_camera.R = nearest_rotation(out.state.T_base_camera.R);
  return out;
}

}  // namespace rigcal
