#include "core/board/squares_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/base/median.h"

namespace rigcal {
namespace {

using Eigen::Vector2d;
using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

constexpr double beside_outline = 0.15;  // of a square: nearer to the pattern's end the beam meets what is beside it
constexpr double first_blur = 0.1;       // of a square
constexpr double least_blur = 0.01;
constexpr double most_blur = 0.35;
constexpr double most_moved = 0.3;  // of a square, from the start
constexpr double most_scaled = 0.1;
constexpr int most_steps = 40;
constexpr double still = 1e-5;  // metres, radians, share of the scale
constexpr double huber_sigmas = 2.0;
constexpr double clear_sigmas = 5.0;  // of the difference between the colours
constexpr std::size_t least_spots = 200;

/// One axis of the pattern: 1 and -1 in turn from line to line, with derivatives.
struct Wave {
  double value = 0.0;
  double by_place = 0.0;  ///< Per metre.
  double by_blur = 0.0;
};

Wave wave_at(double lines, double square, double blur) {
  const double line = std::round(lines);
  const double sign = std::fmod(std::abs(line), 2.0) < 0.5 ? 1.0 : -1.0;
  const double off = (lines - line) * square;
  const double t = std::tanh(off / blur);
  const double slope = sign * (1.0 - t * t) / blur;
  return {sign * t, slope, -slope * off / blur};
}

/// Unknowns: shift, angle, logarithm of the scale, mean, swing, blur.
struct State {
  SquaresPlace place;
  double mean = 0.0;
  double swing = 0.0;
  double blur_m = 0.0;

  void move(const Vector7& step, double square) {
    place.shift += step.head<2>();
    place.angle_rad += step[2];
    place.scale *= std::exp(std::clamp(step[3], -0.1, 0.1));
    mean += step[4];
    swing += step[5];
    blur_m = std::clamp(blur_m + step[6], least_blur * square, most_blur * square);
  }
};

/// Residual (seen less expected) and the derivatives of what is expected; false beside the pattern.
bool residual_at(const SquareSpot& spot, const BoardModel& board, const State& at, double& residual, Vector7& by) {
  const double c = std::cos(at.place.angle_rad);
  const double s = std::sin(at.place.angle_rad);
  const Vector2d off = (spot.at - at.place.shift) / at.place.scale;
  const Vector2d q(c * off.x() + s * off.y(), -s * off.x() + c * off.y());
  const Vector2d lines = (q - board.offset()) / board.square() + 0.5 * Vector2d(board.columns() + 1, board.rows() + 1);
  const Vector2d end(board.columns() + 1, board.rows() + 1);
  if (lines.minCoeff() < beside_outline || (end - lines).minCoeff() < beside_outline) return false;
  const Wave x = wave_at(lines.x(), board.square(), at.blur_m);
  const Wave y = wave_at(lines.y(), board.square(), at.blur_m);
  residual = spot.reflectivity - at.mean - at.swing * x.value * y.value;
  const Vector2d by_q = at.swing * Vector2d(x.by_place * y.value, x.value * y.by_place);
  by[0] = -(by_q.x() * c - by_q.y() * s) / at.place.scale;
  by[1] = -(by_q.x() * s + by_q.y() * c) / at.place.scale;
  by[2] = by_q.x() * q.y() - by_q.y() * q.x();
  by[3] = -by_q.dot(q);
  by[4] = 1.0;
  by[5] = x.value * y.value;
  by[6] = at.swing * (x.by_blur * y.value + x.value * y.by_blur);
  return true;
}

struct Normal {
  Matrix7 H = Matrix7::Zero();
  Matrix7 scatter = Matrix7::Zero();  ///< Of the gradient from point to point: next to the lines they scatter more.
  Vector7 g = Vector7::Zero();
  double weight = 0.0;
  double sigma = 0.0;  ///< By the median: for the weights of the next step.
};

Normal normal_at(const std::vector<SquareSpot>& spots, const BoardModel& board, const State& at, double sigma) {
  Normal out;
  std::vector<double> sizes;
  sizes.reserve(spots.size());
  double residual = 0.0;
  Vector7 by;
  for (const SquareSpot& spot : spots) {
    if (!residual_at(spot, board, at, residual, by)) continue;
    sizes.push_back(std::abs(residual));
    const double weight = sigma > 0.0 ? std::min(1.0, huber_sigmas * sigma / std::max(1e-9, std::abs(residual))) : 1.0;
    out.H.noalias() += weight * by * by.transpose();
    out.g += weight * residual * by;
    out.scatter.noalias() += weight * weight * residual * residual * by * by.transpose();
    out.weight += weight;
  }
  if (!sizes.empty()) out.sigma = std::max(0.5, sigma_per_median_size * median(sizes));
  return out;
}

// Mean and half the difference of the two colours under the start.
State first_state(const std::vector<SquareSpot>& spots, const BoardModel& board, const SquaresPlace& start) {
  State out{start, 0.0, 1.0, first_blur * board.square()};
  double n = 0.0;
  double sums[2] = {};
  double squares = 0.0;
  double residual = 0.0;
  Vector7 by;
  for (const SquareSpot& spot : spots) {
    if (!residual_at(spot, board, out, residual, by)) continue;
    n += 1.0;
    sums[0] += spot.reflectivity;
    sums[1] += by[5] * spot.reflectivity;
    squares += by[5] * by[5];
  }
  out.mean = sums[0] / std::max(1.0, n);
  out.swing = sums[1] / std::max(1.0, squares);
  return out;
}

}  // namespace

std::optional<SquaresFit> fit_squares(const std::vector<SquareSpot>& spots, const BoardModel& board,
                                      const SquaresPlace& start) {
  State at = first_state(spots, board, start);
  double sigma = 0.0;
  bool settled = false;
  for (int step = 0; step < most_steps && !settled; ++step) {
    const Normal normal = normal_at(spots, board, at, sigma);
    if (normal.weight < static_cast<double>(least_spots)) return std::nullopt;
    Matrix7 H = normal.H;
    H.diagonal() *= 1.0 + 1e-6;
    const Vector7 move = H.ldlt().solve(normal.g);
    if (!move.allFinite()) return std::nullopt;
    at.move(move, board.square());
    sigma = normal.sigma;
    settled = step > 2 && move.head<4>().cwiseAbs().maxCoeff() < still;
    const double moved = (at.place.shift - start.shift).norm();
    if (moved > most_moved * board.square() || std::abs(std::log(at.place.scale / start.scale)) > most_scaled) {
      return std::nullopt;
    }
  }
  const Normal last = normal_at(spots, board, at, sigma);
  const Matrix7 inverse = last.H.inverse();
  const Matrix7 covariance = inverse * last.scatter * inverse;
  if (!settled || !covariance.allFinite() || covariance.diagonal().minCoeff() <= 0.0) return std::nullopt;
  if (std::abs(at.swing) < clear_sigmas * std::sqrt(covariance(5, 5))) return std::nullopt;
  SquaresFit out;
  out.place = at.place;
  out.shift_sigma_m = std::sqrt(0.5 * (covariance(0, 0) + covariance(1, 1)));
  out.angle_sigma_rad = std::sqrt(covariance(2, 2));
  out.scale_sigma = std::sqrt(covariance(3, 3));
  out.blur_m = at.blur_m;
  return out;
}

}  // namespace rigcal
