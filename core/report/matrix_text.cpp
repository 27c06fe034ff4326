#include "core/report/matrix_text.h"

#include "core/base/text.h"

namespace rigcal {

std::string list_text(const Eigen::Ref<const Eigen::VectorXd>& values) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) text += (i == 0 ? "" : ", ") + number_text(values[i]);
  return text + "]";
}

std::string matrix_text(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    text += (i == 0 ? "" : ", ") + list_text(matrix.row(i).transpose());
  }
  return text + "]";
}

}  // namespace rigcal
