#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

namespace rigcal {

/// A number with 17 significant digits, so that reading it back gives the same bits, and always with a point
/// ("1.0e-05"), so that every YAML reader takes it for a number. Independent of the locale. `value` must be finite.
[[nodiscard]] std::string number_text(double value);

/// "[a, b, c]" of the numbers of a vector.
[[nodiscard]] std::string list_text(const Eigen::Ref<const Eigen::VectorXd>& values);

/// "[[...], [...]]", row by row.
[[nodiscard]] std::string matrix_text(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

/// A text as a YAML scalar in double quotes; control characters are escaped.
[[nodiscard]] std::string quoted_text(std::string_view text);

/// A text as a YAML key: plain where that is safe, quoted otherwise.
[[nodiscard]] std::string key_text(std::string_view text);

}  // namespace rigcal
