#include "core/start/noise_estimate.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace rigcal {
namespace {

struct Bin {
  std::vector<double> variances;
  double cos2 = 0.0;
  double r2 = 0.0;
};

// Where the lower third of what a scatter of `points` points gives ends, over its variance: a chi-square variable with
// three degrees of freedom taken by the plane, by Wilson and Hilferty.
double lower_third(double points) {
  const double nu = points - 3.0;
  const double root = 1.0 - 2.0 / (9.0 * nu) - 0.4307 * std::sqrt(2.0 / (9.0 * nu));
  return root * root * root;
}

// The surfels of one LiDAR by range (thirds of an octave) and incidence (five steps of cos^2).
std::map<std::pair<int, int>, Bin> binned(const std::vector<PatchSurfels>& patches, int lidar) {
  std::map<std::pair<int, int>, Bin> bins;
  for (const PatchSurfels& patch : patches) {
    if (patch.lidar != lidar) continue;
    for (const Surfel& s : patch.surfels) {
      const double r2 = s.mean.squaredNorm();
      const double cos2 = std::pow(s.normal.dot(s.mean), 2) / r2;
      Bin& bin = bins[{static_cast<int>(std::floor(1.5 * std::log2(r2))), std::min(4, static_cast<int>(5.0 * cos2))}];
      bin.variances.push_back(s.variance / lower_third(s.N));
      bin.cos2 += cos2;
      bin.r2 += r2;
    }
  }
  return bins;
}

}  // namespace

NoiseModel estimate_noise(const std::vector<PatchSurfels>& patches, int lidar, const NoiseModel& fallback) {
  std::vector<std::pair<Vector3d, double>> rows;  // (cos^2, r^2 cos^2, r^2 sin^2) / variance, number of surfels
  double surfels = 0.0;
  for (auto& [key, bin] : binned(patches, lidar)) {
    const auto n = static_cast<double>(bin.variances.size());
    surfels += n;
    if (n < 5.0) continue;
    // The lower third: what is thicker is rough or curved, not noise.
    std::vector<double> v = bin.variances;
    const auto at = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 3);
    std::nth_element(v.begin(), at, v.end());
    const double cos2 = bin.cos2 / n;
    const double r2 = bin.r2 / n;
    rows.emplace_back(Vector3d(cos2, r2 * cos2, r2 * (1.0 - cos2)) / std::max(*at, 1e-8), std::min(n, 200.0));
  }
  if (surfels < 60.0 || rows.size() < 3) return fallback;
  // Relative least squares, sum n (model / seen - 1)^2, with no negative share: the worst is dropped until none is
  // left.
  std::array<bool, 3> used{true, true, true};
  Vector3d x = Vector3d::Zero();
  for (int round = 0; round < 3; ++round) {
    Matrix3d A = Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (const auto& [row, n] : rows) {
      A += n * row * row.transpose();
      b += n * row;
    }
    for (int k = 0; k < 3; ++k) {
      if (used[static_cast<std::size_t>(k)]) continue;
      A.row(k).setZero();
      A.col(k).setZero();
      A(k, k) = 1.0;
      b[k] = 0.0;
    }
    x = A.ldlt().solve(b);
    int worst = 0;
    if (x.minCoeff(&worst) >= 0.0) break;
    used[static_cast<std::size_t>(worst)] = false;
  }
  NoiseModel noise;
  noise.range_m = std::max(0.003, std::sqrt(std::max(0.0, x[0])));
  noise.range_per_m = std::sqrt(std::max(0.0, x[1]));
  noise.angle_rad = std::max(1e-5, std::sqrt(std::max(0.0, x[2])));
  return noise;
}

}  // namespace rigcal
