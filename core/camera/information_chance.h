#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/camera/joint_histogram.h"
#include "core/camera/sightings.h"

namespace rigcal {

/// What chance alone takes off the information distance of a histogram of so few sightings, to first order (Miller
/// 1955): places at which little is seen would win by it.
class InformationChance {
 public:
  explicit InformationChance(std::span<const Sighting> sightings) {
    std::array<char, surface_codes_count> met{};
    for (const Sighting& s : sightings) met[s.code] = 1;
    const double codes = std::max(2.0, static_cast<double>(std::count(met.begin(), met.end(), 1)));
    bins_ = (codes - 1.0) * (grey_levels - 1);
    entropy_ = std::log(codes * grey_levels);
  }
  [[nodiscard]] double gain(double seen) const { return bins_ / (2.0 * std::max(seen, 1.0) * entropy_); }

 private:
  double bins_ = 0.0;
  double entropy_ = 1.0;  // of the joint histogram, at most
};

}  // namespace rigcal
