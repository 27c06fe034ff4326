#include "core/board/board_jackknife.h"

#include <ceres/crs_matrix.h>

#include <Eigen/Cholesky>

namespace rigcal {
namespace {

constexpr int own_size = 6;

// Normal equations of the shared unknowns and of one board's pose.
struct Normals {
  Eigen::MatrixXd shared;
  Eigen::MatrixXd across;
  Eigen::Matrix<double, own_size, own_size> own = Eigen::Matrix<double, own_size, own_size>::Zero();
  Eigen::VectorXd gradient;  ///< Of the shared ones.

  explicit Normals(int size)
      : shared(Eigen::MatrixXd::Zero(size, size)),
        across(Eigen::MatrixXd::Zero(size, own_size)),
        gradient(Eigen::VectorXd::Zero(size)) {}

  void add(const ceres::CRSMatrix& J, int row, double residual) {
    const int size = static_cast<int>(gradient.size());
    for (int i = J.rows[row]; i < J.rows[row + 1]; ++i) {
      const int a = J.cols[i];
      if (a < size) gradient[a] += J.values[i] * residual;
      for (int k = J.rows[row]; k < J.rows[row + 1]; ++k) {
        const int b = J.cols[k];
        const double product = J.values[i] * J.values[k];
        if (a < size && b < size) shared(a, b) += product;
        if (a < size && b >= size) across(a, (b - size) % own_size) += product;
        if (a >= size && b >= size) own((a - size) % own_size, (b - size) % own_size) += product;
      }
    }
  }
  // With the board's pose free.
  [[nodiscard]] Eigen::MatrixXd reduced() const { return shared - across * own.ldlt().solve(across.transpose()); }
};

}  // namespace

Eigen::MatrixXd jackknife_covariance(const ceres::CRSMatrix& J, const std::vector<double>& residuals, int shared) {
  const auto boards = static_cast<std::size_t>((J.num_cols - shared) / own_size);
  if (shared == 0 || boards < least_jackknife_boards) return Eigen::MatrixXd::Zero(shared, shared);
  Normals rest(shared);
  std::vector<Normals> all(boards, rest);
  for (int row = 0; row < J.num_rows; ++row) {
    int own = -1;
    for (int i = J.rows[row]; i < J.rows[row + 1]; ++i) {
      if (J.cols[i] >= shared) own = (J.cols[i] - shared) / own_size;
    }
    (own < 0 ? rest : all[static_cast<std::size_t>(own)]).add(J, row, residuals[static_cast<std::size_t>(row)]);
  }
  Eigen::MatrixXd sum = rest.shared;
  for (const Normals& board : all) sum += board.reduced();
  Eigen::MatrixXd moves(shared, static_cast<Eigen::Index>(boards));
  for (std::size_t k = 0; k < boards; ++k) {
    // At the minimum all gradients sum up to zero: without this board the step is by its own.
    moves.col(static_cast<Eigen::Index>(k)) = (sum - all[k].reduced()).ldlt().solve(all[k].gradient);
  }
  if (!moves.allFinite()) return Eigen::MatrixXd::Zero(shared, shared);
  moves.colwise() -= moves.rowwise().mean().eval();
  const auto count = static_cast<double>(boards);
  return (count - 1.0) / count * moves * moves.transpose();
}

}  // namespace rigcal
