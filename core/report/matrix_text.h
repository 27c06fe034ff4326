#pragma once

#include <Eigen/Core>
#include <string>

namespace rigcal {

/// "[a, b, c]" of the numbers of a vector, each as number_text writes it.
[[nodiscard]] std::string list_text(const Eigen::Ref<const Eigen::VectorXd>& values);

/// "[[...], [...]]", row by row.
[[nodiscard]] std::string matrix_text(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

}  // namespace rigcal
