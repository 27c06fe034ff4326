#pragma once

#include <vector>

#include "core/planes/plane_factor.h"

namespace rigcal {

/// Which parameters are free and where each stands in the vector of unknowns: six for each free stop, then six for each
/// free LiDAR, right perturbations [rotation; translation].
class ParameterLayout {
 public:
  ParameterLayout(int stops, int lidars);
  void free_stop(int stop);
  void free_lidar(int lidar);

  [[nodiscard]] int size() const { return size_; }
  /// First index of the block, or -1 where it is fixed.
  [[nodiscard]] int stop_index(int stop) const { return stop_index_[static_cast<std::size_t>(stop)]; }
  [[nodiscard]] int lidar_index(int lidar) const { return lidar_index_[static_cast<std::size_t>(lidar)]; }
  [[nodiscard]] int stops() const { return static_cast<int>(stop_index_.size()); }
  [[nodiscard]] int lidars() const { return static_cast<int>(lidar_index_.size()); }
  /// state with T exp(dx) on every free block.
  [[nodiscard]] RigState moved(const RigState& state, const Eigen::VectorXd& dx) const;

 private:
  std::vector<int> stop_index_;
  std::vector<int> lidar_index_;
  int size_ = 0;
};

/// Cost, gradient and Hessian of the sum of all plane costs.
struct NormalEquations {
  double cost = 0.0;
  Eigen::VectorXd g;
  Eigen::MatrixXd H;

  NormalEquations& operator+=(const NormalEquations& other);
};

/// Sums over all features in a fixed order, on all threads. `exact` adds the second derivatives of the chain
/// T_G_sensor = G exp(a) E exp(c) (gradient times curvature), so that H is the Hessian to the last term.
[[nodiscard]] NormalEquations build_normal_equations(const std::vector<PlaneFeature>& features, const RigState& state,
                                                     const ParameterLayout& layout, HessianForm form);

[[nodiscard]] double total_cost(const std::vector<PlaneFeature>& features, const RigState& state);

}  // namespace rigcal
