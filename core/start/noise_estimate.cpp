#include "core/start/noise_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "core/base/median.h"
#include "core/geometry/symmetric_solve.h"

namespace rigcal {
namespace {

// Relative error of a bin's variance: of what is not noise, and of chance, as the square for a single surfel.
constexpr double bin_error = 0.1;
constexpr double surfel_variance = 0.08;
// A plane that is met at a smaller cosine holds the rays: it is a piece of one ring of a spinning LiDAR, which noise
// along them or a corner widens to a plane without any thickness. A bin that has more of these than this share would
// say that there is no noise, and by its relative error count more than all others.
constexpr double least_cos = 0.01;
constexpr double most_lines = 0.25;
// Growths that are tried: a LiDAR's spot is drawn out, but its echo is not many times as long.
constexpr double most_growth = 1.0;
constexpr double growth_step = 0.05;
// Its sigma before anything is seen: without grazed surfaces it is taken for none.
constexpr double usual_growth = 0.3;
// Real surfaces are flat to a fifth of noise: more points than these say no more.
constexpr double most_freedom = 50.0;
// Of expectation maximisation.
constexpr int rounds = 8;

// A surfel as the law sees it.
struct Thickness {
  double variance = 0.0;  // m^2
  double freedom = 0.0;   // its points less the three that its plane takes
  double cos = 0.0;       // of the incidence
  double r2 = 0.0;        // m^2
};

// Surfels that are seen from a like distance at a like angle.
struct Bin {
  std::vector<Thickness> surfels;
  double cos = 0.0;
  double r2 = 0.0;
  double noise_share = 0.7;  // of the surfels: the others are rough, curved or two surfaces
  double variance = 0.0;     // what the law shall give at cos and r2
  double weight = 0.0;       // one over the square of its relative error
};

struct Shares {
  Vector3d x = Vector3d::Zero();  // squares of range_m, range_per_m and angle_rad
  double cost = 0.0;
};

// Where the lower third of what a scatter of this freedom gives ends, over its variance: a chi-square variable, by
// Wilson and Hilferty.
double lower_third(double freedom) {
  const double root = 1.0 - 2.0 / (9.0 * freedom) - 0.4307 * std::sqrt(2.0 / (9.0 * freedom));
  return root * root * root;
}

void leave_lines_out(Bin& bin) {
  const auto is_line = [](const Thickness& s) { return s.cos < least_cos; };
  const auto lines = std::count_if(bin.surfels.begin(), bin.surfels.end(), is_line);
  if (static_cast<double>(lines) > most_lines * static_cast<double>(bin.surfels.size()))
    std::erase_if(bin.surfels, is_line);
}

// The surfels of one LiDAR by range (thirds of an octave) and incidence (five steps of cos^2).
std::vector<Bin> binned(const std::vector<PatchSurfels>& patches, int lidar) {
  std::map<std::pair<int, int>, Bin> bins;
  for (const PatchSurfels& patch : patches) {
    if (patch.lidar != lidar) continue;
    for (const Surfel& s : patch.surfels) {
      const double r2 = s.mean.squaredNorm();
      const double cos2 = std::pow(s.normal.dot(s.mean), 2) / r2;
      Bin& bin = bins[{static_cast<int>(std::floor(1.5 * std::log2(r2))), std::min(4, static_cast<int>(5.0 * cos2))}];
      bin.surfels.push_back({s.variance, s.N - 3.0, std::sqrt(cos2), r2});
    }
  }
  std::vector<Bin> out;
  for (auto& [key, bin] : bins) {
    leave_lines_out(bin);
    if (bin.surfels.empty()) continue;
    for (const Thickness& s : bin.surfels) {
      bin.cos += s.cos;
      bin.r2 += s.r2;
    }
    const auto n = static_cast<double>(bin.surfels.size());
    bin.cos /= n;
    bin.r2 /= n;
    out.push_back(std::move(bin));
  }
  return out;
}

// A first guess: the lower third of each bin. What is thicker is rough or curved, not noise.
void take_lower_thirds(std::vector<Bin>& bins) {
  std::vector<double> v;
  for (Bin& bin : bins) {
    v.clear();
    for (const Thickness& s : bin.surfels) v.push_back(s.variance / lower_third(s.freedom));
    bin.variance = std::max(of_rank(v, v.size() / 3), 1e-8);
    bin.weight = 1.0 / (bin_error * bin_error + surfel_variance / static_cast<double>(v.size()));
  }
}

// Each surfel is as thick as noise, a gamma variable about the law's variance, or anything from a tenth to ten times
// that. The mean of the first kind, over the law, says what the law shall give (a step of expectation maximisation).
void take_noise(const NoiseModel& law, std::vector<Bin>& bins) {
  constexpr double anything = 1.0 / (2.0 * std::numbers::ln10);  // density over the logarithm
  const auto law_at = [&](double cos, double r2) {
    const Vector3d normal(cos, std::sqrt(std::max(0.0, 1.0 - cos * cos)), 0.0);
    return law.variance_along(std::sqrt(r2) * Vector3d::UnitX(), normal);
  };
  for (Bin& bin : bins) {
    double shares = 0.0;
    double weight = 0.0;
    double seen = 0.0;
    for (const Thickness& s : bin.surfels) {
      const double k = 0.5 * std::min(s.freedom, most_freedom);
      const double ratio = s.variance / law_at(s.cos, s.r2);
      if (!(ratio > 0.01 && ratio < 100.0)) continue;
      // Stirling's formula for the gamma function.
      const double noise = std::sqrt(k / (2.0 * pi)) * std::exp(k * (1.0 + std::log(ratio) - ratio) - 1.0 / (12.0 * k));
      const double is_noise = bin.noise_share * noise / (bin.noise_share * noise + (1.0 - bin.noise_share) * anything);
      shares += is_noise;
      weight += is_noise * k;
      seen += is_noise * k * ratio;
    }
    bin.noise_share = std::clamp(shares / static_cast<double>(bin.surfels.size()), 0.05, 0.95);
    bin.variance = std::max(weight > 0.0 ? seen / weight * law_at(bin.cos, bin.r2) : 0.0, 1e-8);
    // A gamma variable's relative variance is 1 / k.
    bin.weight = weight > 0.0 ? 1.0 / (bin_error * bin_error + 1.0 / weight) : 0.0;
  }
}

// Relative least squares, sum w (model / seen - 1)^2, with no negative share: the worst is dropped until none is left.
Shares fit(const std::vector<Bin>& bins, double growth) {
  std::vector<std::pair<Vector3d, double>> rows;
  for (const Bin& bin : bins) {
    const double cos2 = bin.cos * bin.cos;
    const double along = cos2 * std::pow(1.0 + growth * (1.0 - bin.cos), 2);
    rows.emplace_back(Vector3d(along, bin.r2 * along, bin.r2 * (1.0 - cos2)) / bin.variance, bin.weight);
  }
  std::array<bool, 3> used{true, true, true};
  Shares shares;
  for (int round = 0; round < 3; ++round) {
    Matrix3d A = Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (const auto& [row, w] : rows) {
      A += w * row * row.transpose();
      b += w * row;
    }
    for (int k = 0; k < 3; ++k) {
      if (used[static_cast<std::size_t>(k)]) continue;
      A.row(k).setZero();
      A.col(k).setZero();
      A(k, k) = 1.0;
      b[k] = 0.0;
    }
    shares.x = solve_symmetric3(A, b);
    int worst = 0;
    if (shares.x.minCoeff(&worst) >= 0.0) break;
    used[static_cast<std::size_t>(worst)] = false;
  }
  shares.x = shares.x.cwiseMax(0.0);
  for (const auto& [row, w] : rows) shares.cost += w * std::pow(row.dot(shares.x) - 1.0, 2);
  return shares;
}

NoiseModel law_of(const std::vector<Bin>& bins) {
  NoiseModel best;
  double least = std::numeric_limits<double>::infinity();
  for (double growth = 0.0; growth <= most_growth; growth += growth_step) {
    const Shares shares = fit(bins, growth);
    const double cost = shares.cost + std::pow(growth / usual_growth, 2);
    if (cost >= least) continue;
    least = cost;
    best.range_m = std::max(0.003, std::sqrt(shares.x[0]));
    best.range_per_m = std::sqrt(shares.x[1]);
    best.angle_rad = std::max(1e-5, std::sqrt(shares.x[2]));
    best.slant_growth = growth;
  }
  return best;
}

}  // namespace

NoiseModel estimate_noise(const std::vector<PatchSurfels>& patches, int lidar, const NoiseModel& fallback) {
  std::vector<Bin> bins = binned(patches, lidar);
  std::size_t surfels = 0;
  for (const Bin& bin : bins) surfels += bin.surfels.size();
  std::erase_if(bins, [](const Bin& bin) { return bin.surfels.size() < 5; });
  if (surfels < 60 || bins.size() < 3) return fallback;
  take_lower_thirds(bins);
  NoiseModel law = law_of(bins);
  for (int round = 0; round < rounds; ++round) {
    take_noise(law, bins);
    // Too far off to see any: the law stays as it is.
    if (std::none_of(bins.begin(), bins.end(), [](const Bin& bin) { return bin.weight > 0.0; })) break;
    law = law_of(bins);
  }
  return law;
}

}  // namespace rigcal
