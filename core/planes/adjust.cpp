#include "core/planes/adjust.h"

#include <cmath>

#include "core/planes/positive_solver.h"

namespace rigcal {
namespace {

using Priors = std::vector<std::optional<PosePrior>>;

// Calls f(index, pose, prior) for every free LiDAR that has one.
template <class F>
void for_each_lidar(const Priors& priors, const ParameterLayout& layout, const RigState& state, const F& f) {
  for (std::size_t i = 0; i < priors.size(); ++i) {
    const int index = layout.lidar_index(static_cast<int>(i));
    if (priors[i] && index >= 0) f(index, state.T_base_sensor[i], *priors[i]);
  }
}

template <class F>
void for_each_prior(const ParameterLayout& layout, const AdjustOptions& options, const RigState& state, const F& f) {
  for (std::size_t j = 0; j < options.stop_priors.size(); ++j) {
    const int index = layout.stop_index(static_cast<int>(j));
    if (options.stop_priors[j] && index >= 0) f(index, state.T_G_base[j], *options.stop_priors[j]);
  }
  for_each_lidar(options.lidar_priors, layout, state, f);
  for_each_lidar(options.lidar_matches, layout, state, f);
}

double prior_cost(const ParameterLayout& layout, const AdjustOptions& options, const RigState& state) {
  double cost = 0.0;
  for_each_prior(layout, options, state, [&](int, const SE3& T, const PosePrior& prior) {
    const Vector6d e = (prior.T.inverse() * T).log();
    cost += e.dot(prior.information * e);
  });
  return cost;
}

// The log's Jacobian is taken as one: priors are weak and errors against them small.
void add_prior(int index, const SE3& T, const PosePrior& prior, NormalEquations& sum) {
  const Vector6d e = (prior.T.inverse() * T).log();
  const Vector6d we = prior.information * e;
  sum.cost += e.dot(we);
  sum.g.segment<6>(index) += 2.0 * we;
  sum.H.block<6, 6>(index, index) += 2.0 * prior.information;
}

NormalEquations build(const std::vector<PlaneFeature>& features, const RigState& state, const ParameterLayout& layout,
                      const AdjustOptions& options, HessianForm form) {
  NormalEquations sum = build_normal_equations(features, state, layout, form);
  add_priors(layout, options, state, sum);
  return sum;
}

struct StepSize {
  double rotation = 0.0;
  double translation = 0.0;
};

StepSize step_size(const Eigen::VectorXd& dx) {
  StepSize size;
  for (int i = 0; i + 5 < dx.size(); i += 6) {
    size.rotation = std::max(size.rotation, dx.segment<3>(i).norm());
    size.translation = std::max(size.translation, dx.segment<3>(i + 3).norm());
  }
  return size;
}

Eigen::MatrixXd damped(const NormalEquations& sum, double lambda) {
  Eigen::MatrixXd A = sum.H;
  A.diagonal() += lambda * sum.H.diagonal().cwiseAbs();
  // What nothing holds at all, a LiDAR or stop on no plane, has no gradient and stays: it must not stop the others.
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    if (A(i, i) == 0.0) A(i, i) = 1.0;
  }
  return A;
}

}  // namespace

PosePrior isotropic_prior(const SE3& T, double rotation_rad, double translation_m) {
  PosePrior prior{T, Matrix6d::Zero()};
  prior.information.diagonal().head<3>().setConstant(1.0 / (rotation_rad * rotation_rad));
  prior.information.diagonal().tail<3>().setConstant(1.0 / (translation_m * translation_m));
  return prior;
}

void add_priors(const ParameterLayout& layout, const AdjustOptions& options, const RigState& state,
                NormalEquations& sum) {
  for_each_prior(layout, options, state,
                 [&](int index, const SE3& T, const PosePrior& prior) { add_prior(index, T, prior, sum); });
}

void add_matches(const ParameterLayout& layout, const AdjustOptions& options, const RigState& state,
                 NormalEquations& sum) {
  for_each_lidar(options.lidar_matches, layout, state,
                 [&](int index, const SE3& T, const PosePrior& prior) { add_prior(index, T, prior, sum); });
}

AdjustSummary adjust(const std::vector<PlaneFeature>& features, const ParameterLayout& layout,
                     const AdjustOptions& options, RigState& state) {
  AdjustSummary summary;
  if (layout.size() == 0 || features.empty()) return summary;
  double lambda = 1e-6;
  NormalEquations sum = build(features, state, layout, options, options.form);
  summary.cost_before = sum.cost;
  summary.costs.push_back(sum.cost);
  for (; summary.iterations < options.max_iterations; ++summary.iterations) {
    std::optional<Eigen::VectorXd> back = solve_positive(damped(sum, lambda), sum.g);
    if (!back && options.form == HessianForm::exact) {
      const NormalEquations gauss_newton = build(features, state, layout, options, HessianForm::gauss_newton);
      back = solve_positive(damped(gauss_newton, lambda), sum.g);
    }
    if (!back) {
      lambda = std::max(1e-4, 10.0 * lambda);
      if (lambda > 1e6) break;
      summary.costs.push_back(sum.cost);
      continue;
    }
    const Eigen::VectorXd dx = -*back;
    const RigState moved = layout.moved(state, dx);
    const double cost = total_cost(features, moved) + prior_cost(layout, options, moved);
    const StepSize size = step_size(dx);
    const bool tiny =
        size.rotation < options.rotation_tolerance_rad && size.translation < options.translation_tolerance_m;
    if (std::isfinite(cost) && cost <= sum.cost) {
      state = moved;
      lambda = std::max(1e-9, 0.1 * lambda);
      summary.costs.push_back(cost);
      if (tiny) {
        sum.cost = cost;
        summary.converged = true;
        ++summary.iterations;
        break;
      }
      sum = build(features, state, layout, options, options.form);
    } else {
      summary.costs.push_back(summary.costs.back());  // sum.cost is the same but for rounding
      lambda = std::max(1e-6, 10.0 * lambda);
      // A refused step below the tolerance is rounding: there is nothing left to gain.
      if (tiny || lambda > 1e8) {
        summary.converged = tiny;
        ++summary.iterations;
        break;
      }
    }
  }
  summary.cost_after = sum.cost;
  return summary;
}

}  // namespace rigcal
