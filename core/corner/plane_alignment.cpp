#include "core/corner/plane_alignment.h"

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace rigcal {
namespace {

using Pose = Eigen::Matrix<double, 6, 1>;  // [phi; t] for R = R_start exp(phi)

SE3 pose_at(const SE3& start, const double* parameters) {
  const Eigen::Map<const Pose> x(parameters);
  return {start.R * exp_so3(x.head<3>()), x.tail<3>()};
}

// A pair as Ceres wants it, with the chart of rotations around the start.
class PairCost final : public ceres::SizedCostFunction<8, 6> {
 public:
  PairCost(const PlanePair& pair, const SE3& start) : pair_(pair), start_(start) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Matrix<double, 8, 1> values;
    Eigen::Matrix<double, 8, 6> J;
    const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
    pair_residuals(pair_, pose_at(start_, parameters[0]), values, wanted ? &J : nullptr);
    Eigen::Map<Eigen::Matrix<double, 8, 1>>{residuals} = values;
    if (!wanted) return true;
    // exp(phi + d) = exp(phi) exp(J_l(-phi) d).
    const Vector3d phi = Eigen::Map<const Pose>(parameters[0]).head<3>();
    J.leftCols<3>() = (J.leftCols<3>() * left_jacobian_so3(-phi)).eval();
    Eigen::Map<Eigen::Matrix<double, 8, 6, Eigen::RowMajor>>{jacobians[0]} = J;
    return true;
  }

 private:
  const PlanePair& pair_;
  SE3 start_;
};

}  // namespace

void pair_residuals(const PlanePair& pair, const SE3& T, Eigen::Matrix<double, 8, 1>& residuals,
                    Eigen::Matrix<double, 8, 6>* jacobian) {
  if (jacobian != nullptr) jacobian->setZero();
  const PlaneMoments b = moments_of(pair.b.points);
  const PlaneMoments a = moments_of(pair.a.points);
  const Vector3d n_in_b = T.R.transpose() * pair.a.normal;
  const Vector3d n_in_a = T.R * pair.b.normal;
  for (int k = 0; k < 3; ++k) {
    const double root_b = std::sqrt(pair.weight_b * b.scatter[k]);
    const double root_a = std::sqrt(pair.weight_a * a.scatter[k]);
    residuals[k] = root_b * b.axes.col(k).dot(n_in_b);
    residuals[4 + k] = root_a * a.axes.col(k).dot(n_in_a);
    if (jacobian == nullptr) continue;
    jacobian->block<1, 3>(k, 0) = root_b * b.axes.col(k).transpose() * skew(n_in_b);
    jacobian->block<1, 3>(4 + k, 0) = -root_a * a.axes.col(k).transpose() * T.R * skew(pair.b.normal);
  }
  const double root_b = std::sqrt(pair.weight_b * b.N);
  const double root_a = std::sqrt(pair.weight_a * a.N);
  const Vector3d a_in_b = T.R.transpose() * (a.mean - T.t);
  residuals[3] = root_b * pair.a.distance(T * b.mean);
  residuals[7] = root_a * pair.b.distance(a_in_b);
  if (jacobian == nullptr) return;
  jacobian->block<1, 3>(3, 0) = root_b * b.mean.cross(n_in_b).transpose();
  jacobian->block<1, 3>(3, 3) = root_b * pair.a.normal.transpose();
  jacobian->block<1, 3>(7, 0) = root_a * pair.b.normal.cross(a_in_b).transpose();
  jacobian->block<1, 3>(7, 3) = -root_a * n_in_a.transpose();
}

PlaneAlignment align_planes(std::span<const PlanePair> pairs, const SE3& start, double robust_scale) {
  PlaneAlignment out;
  out.T_a_b = start;
  if (pairs.empty()) return out;
  Pose x;
  x << Vector3d::Zero(), start.t;
  ceres::Problem problem;
  for (const PlanePair& pair : pairs) {
    ceres::LossFunction* loss = robust_scale > 0.0 ? new ceres::CauchyLoss(robust_scale) : nullptr;
    problem.AddResidualBlock(new PairCost(pair, start), loss, x.data());
  }
  ceres::Solver::Options solver;
  solver.max_num_iterations = 60;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.function_tolerance = 1e-14;
  solver.gradient_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  out.T_a_b = pose_at(start, x.data());
  out.T_a_b.R = nearest_rotation(out.T_a_b.R);
  out.cost_before = 2.0 * summary.initial_cost;  // Ceres halves.
  out.cost_after = 2.0 * summary.final_cost;
  out.iterations = static_cast<int>(summary.iterations.size());
  out.converged = summary.termination_type == ceres::CONVERGENCE;
  return out;
}

}  // namespace rigcal
