#include "core/camera/surface_codes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/se3.h"

namespace rigcal {
namespace {

using Ranks = std::array<std::uint8_t, 256>;  // of each value

Ranks ranks_from(const std::array<std::size_t, 256>& count) {
  std::size_t total = 0;
  for (const std::size_t n : count) total += n;
  Ranks ranks{};
  std::size_t below = 0;
  for (std::size_t v = 0; v < count.size(); ++v) {
    // The middle of the value's own share, so that a value that all have is a rank in the middle.
    const double share = (static_cast<double>(below) + 0.5 * static_cast<double>(count[v])) /
                         static_cast<double>(std::max<std::size_t>(1, total));
    ranks[v] = static_cast<std::uint8_t>(std::min(reflectivity_ranks - 1.0, reflectivity_ranks * share));
    below += count[v];
  }
  return ranks;
}

int facing_of(const Eigen::Vector3f& n) {
  if (n.squaredNorm() == 0.0F) return 0;
  if (n.z() * n.z() > 0.5F) return n.z() > 0.0F ? 1 : 2;
  const double turn = std::atan2(n.y(), n.x()) / (2.0 * pi) + 0.5;
  return 3 + std::clamp(static_cast<int>(8.0 * turn), 0, 7);
}

}  // namespace

SurfaceCodes surface_codes(std::span<const MapSample> samples) {
  std::vector<std::array<std::size_t, 256>> counts(256);
  for (const MapSample& s : samples) ++counts[s.lidar][s.reflectivity];
  std::vector<Ranks> ranks;
  for (const auto& count : counts) ranks.push_back(ranks_from(count));
  SurfaceCodes codes;
  codes.of_sample.reserve(samples.size());
  for (const MapSample& s : samples) {
    const int rank = ranks[s.lidar][s.reflectivity];
    codes.of_sample.push_back(static_cast<std::uint8_t>(facing_of(s.normal_G) * reflectivity_ranks + rank));
  }
  return codes;
}

}  // namespace rigcal
