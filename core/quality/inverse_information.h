#pragma once

#include <Eigen/Core>

namespace rigcal {

/// The inverse of a symmetric information matrix, directions of (almost) no information held at a variance that nobody
/// takes for knowledge.
[[nodiscard]] Eigen::MatrixXd inverse_information(const Eigen::MatrixXd& H);

}  // namespace rigcal
