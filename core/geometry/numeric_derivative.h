#pragma once

#include <Eigen/Core>
#include <functional>

namespace rigcal {

/// Central differences of f at 0 along each of `dimension` coordinates, with Richardson's extrapolation (error h^4):
/// what every analytic gradient and Jacobian is checked against. Returns rows = size of f, columns = dimension.
[[nodiscard]] inline Eigen::MatrixXd numeric_jacobian(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& f,
                                                      int dimension, double step = 1e-4) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(dimension);
  Eigen::MatrixXd J(f(x).size(), dimension);
  for (int i = 0; i < dimension; ++i) {
    const auto difference = [&](double h) -> Eigen::VectorXd {
      Eigen::VectorXd plus = x;
      Eigen::VectorXd minus = x;
      plus[i] += h;
      minus[i] -= h;
      return (f(plus) - f(minus)) / (2.0 * h);
    };
    J.col(i) = (4.0 * difference(step / 2.0) - difference(step)) / 3.0;
  }
  return J;
}

}  // namespace rigcal
