#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/records/records.h"

namespace rigcal {

/// Takes out of a LiDAR's points what is no measurement: noise by the tag, and what lies outside the range that the rig
/// file gives. Where it gives none, Livox's points nearer than 1.5 m (distorted) and beyond 200 m (mostly noise) are
/// left out, of other sensors' points none.
class PointFilter {
 public:
  struct LeftOut {
    std::uint64_t noise = 0;  ///< The sensor's tag says so, with high or moderate confidence.
    std::uint64_t out_of_range = 0;
  };

  explicit PointFilter(bool livox = true, const std::optional<std::array<double, 2>>& range_m = std::nullopt);
  /// Leaves the others in their order.
  LeftOut apply(std::vector<Point>& points) const;

 private:
  float least_square_m2_ = 0.0F;
  float most_square_m2_ = 0.0F;
};

}  // namespace rigcal
