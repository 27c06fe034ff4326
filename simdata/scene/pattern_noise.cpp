#include "simdata/scene/pattern_noise.h"

#include <algorithm>
#include <cmath>

namespace rigcal::sim {

double cell_number(std::int64_t a, std::int64_t b, std::int64_t c) {
  // The finaliser of SplitMix64 over the three coordinates, each spread by an odd constant.
  std::uint64_t z = static_cast<std::uint64_t>(a) * 0x9E3779B97F4A7C15ULL;
  z ^= static_cast<std::uint64_t>(b) * 0xC2B2AE3D27D4EB4FULL + (z << 7);
  z ^= static_cast<std::uint64_t>(c) * 0x165667B19E3779F9ULL + (z >> 9);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1.0p-53;
}

double contrast_left(double size, double footprint) { return std::clamp(1.5 - 2.0 * footprint / size, 0.0, 1.0); }

double smooth_noise(const Vector3d& p, double size, double footprint) {
  const double left = contrast_left(size, footprint);
  if (left == 0.0) return 0.0;
  const Vector3d q = p / size;
  const Vector3d cell = q.array().floor();
  const Vector3d f = q - cell;
  const Vector3d blend = f.array().square() * (3.0 - 2.0 * f.array());
  const auto x = static_cast<std::int64_t>(cell.x());
  const auto y = static_cast<std::int64_t>(cell.y());
  const auto z = static_cast<std::int64_t>(cell.z());
  const auto row = [&](std::int64_t dy, std::int64_t dz) {
    const double a = cell_number(x, y + dy, z + dz);
    return a + blend.x() * (cell_number(x + 1, y + dy, z + dz) - a);
  };
  const auto sheet = [&](std::int64_t dz) {
    const double a = row(0, dz);
    return a + blend.y() * (row(1, dz) - a);
  };
  const double low = sheet(0);
  return left * (2.0 * (low + blend.z() * (sheet(1) - low)) - 1.0);
}

double line_share(double x, double period, double width, double footprint) {
  const double w = std::max(footprint, 1e-6);
  // Length of all lines below a place, counted from the beginning of a line.
  const auto below = [&](double at) {
    const double periods = std::floor(at / period);
    return periods * width + std::min(at - periods * period, width);
  };
  const double begin = x + 0.5 * width - 0.5 * w;
  return std::clamp((below(begin + w) - below(begin)) / w, 0.0, 1.0);
}

}  // namespace rigcal::sim
