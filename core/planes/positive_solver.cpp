#include "core/planes/positive_solver.h"

#include <Eigen/Cholesky>
#include <array>
#include <cstring>

#include "core/base/parallel.h"
#include "core/base/wide.h"

namespace rigcal {
namespace {

// Fewer unknowns are solved for sooner than they are cut into tiles.
constexpr Eigen::Index many = 256;

constexpr Eigen::Index tile = 64;
constexpr std::size_t tall = 2;   // registers of a column
constexpr std::size_t broad = 4;  // columns at a time

struct Four {
  static constexpr std::size_t lanes = 4;
  using Lanes = double __attribute__((vector_size(32), aligned(alignof(double))));
};
struct Eight {
  static constexpr std::size_t lanes = 8;
  using Lanes = double __attribute__((vector_size(64), aligned(alignof(double))));
};

// C -= A B^T, all of them tiles of matrices with columns `stride` apart. With more lanes than the processor's registers
// have the sums do not stay in these. The order of each sum does not depend on it.
template <class Registers>
[[gnu::always_inline]] inline void take_product_by(const double* A, const double* B, double* C, std::size_t stride) {
  using Lanes = typename Registers::Lanes;
  constexpr std::size_t lanes = Registers::lanes;
  constexpr auto side = static_cast<std::size_t>(tile);
  constexpr std::size_t rows = tall * lanes;
  // Columns lie pages apart: what is gone through again and again is put together first.
  alignas(64) double right[side * side];
  alignas(64) double left[side * rows];
  for (std::size_t j = 0; j < side; j += broad) {
    for (std::size_t k = 0; k < side; ++k)
      std::memcpy(right + (j * side + k * broad), B + j + k * stride, broad * sizeof(double));
  }
  for (std::size_t i = 0; i < side; i += rows) {
    for (std::size_t k = 0; k < side; ++k) std::memcpy(left + k * rows, A + i + k * stride, rows * sizeof(double));
    for (std::size_t j = 0; j < side; j += broad) {
      Lanes sum[broad][tall] = {};
      for (std::size_t k = 0; k < side; ++k) {
        const double* b = right + j * side + k * broad;
        Lanes a[tall];
        std::memcpy(a, left + k * rows, sizeof a);
        for (std::size_t q = 0; q < broad; ++q) {
          for (std::size_t r = 0; r < tall; ++r) sum[q][r] += a[r] * b[q];
        }
      }
      for (std::size_t q = 0; q < broad; ++q) {
        double* c = C + i + (j + q) * stride;
        Lanes old[tall];
        std::memcpy(old, c, sizeof old);
        for (std::size_t r = 0; r < tall; ++r) old[r] -= sum[q][r];
        std::memcpy(c, old, sizeof old);
      }
    }
  }
}

RIGCAL_WIDE void take_product_by_four(const double* A, const double* B, double* C, std::size_t stride) {
  take_product_by<Four>(A, B, C, stride);
}

RIGCAL_WIDE void take_product_by_eight(const double* A, const double* B, double* C, std::size_t stride) {
  take_product_by<Eight>(A, B, C, stride);
}

void take_product(const double* A, const double* B, double* C, std::size_t stride) {
  static const bool by_eight = has_wide_registers_of_eight();
  (by_eight ? take_product_by_eight : take_product_by_four)(A, B, C, stride);
}

// Its lower triangle becomes the factor; whole tiles. False where it is not positive definite.
bool decompose(Eigen::MatrixXd& A) {
  const Eigen::Index tiles = A.rows() / tile;
  const auto stride = static_cast<std::size_t>(A.rows());
  for (Eigen::Index k = 0; k < tiles; ++k) {
    Eigen::Ref<Eigen::MatrixXd> corner = A.block(k * tile, k * tile, tile, tile);
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(corner);
    if (factor.info() != Eigen::Success) return false;
    const Eigen::Index below = tiles - k - 1;
    parallel_for(static_cast<std::size_t>(below), 1, [&](std::size_t begin, std::size_t) {
      auto part = A.block((k + 1 + static_cast<Eigen::Index>(begin)) * tile, k * tile, tile, tile);
      corner.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(part);
    });
    // All tiles on and below the diagonal, row by row of the triangle.
    parallel_for(static_cast<std::size_t>(below * (below + 1) / 2), 1, [&](std::size_t number, std::size_t) {
      std::size_t row = 0;
      while ((row + 1) * (row + 2) / 2 <= number) ++row;
      const auto i = k + 1 + static_cast<Eigen::Index>(row);
      const auto j = k + 1 + static_cast<Eigen::Index>(number - row * (row + 1) / 2);
      take_product(&A(i * tile, k * tile), &A(j * tile, k * tile), &A(i * tile, j * tile), stride);
    });
  }
  return true;
}

}  // namespace

std::optional<Eigen::VectorXd> solve_positive(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const Eigen::Index n = A.rows();
  if (n < many) {
    const Eigen::LLT<Eigen::MatrixXd> factor(A);
    if (factor.info() != Eigen::Success) return std::nullopt;
    return factor.solve(b);
  }
  const Eigen::Index whole = (n + tile - 1) / tile * tile;
  Eigen::MatrixXd padded = Eigen::MatrixXd::Identity(whole, whole);
  padded.topLeftCorner(n, n) = A;
  if (!decompose(padded)) return std::nullopt;
  const auto L = padded.topLeftCorner(n, n).triangularView<Eigen::Lower>();
  Eigen::VectorXd x = L.solve(b);
  L.transpose().solveInPlace(x);
  return x;
}

}  // namespace rigcal
