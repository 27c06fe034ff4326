#pragma once

#include <array>
#include <vector>

#include "core/camera/surface_codes.h"

namespace rigcal {

/// Grey values 0 .. grey_levels - 1 are told apart.
constexpr int grey_levels = 16;
/// Every value is spread over three bins by a quadratic B-spline, so there is one more at either end.
constexpr int grey_bins = grey_levels + 2;

/// The three bins of a grey value: weight of bin `first`, `first` + 1 and `first` + 2, and their derivatives.
struct GreySpread {
  int first = 0;
  std::array<float, 3> weight{};
  std::array<float, 3> slope{};

  explicit GreySpread(float grey) {
    const float g = grey < 0.0F ? 0.0F : grey > grey_levels - 1.0F ? grey_levels - 1.0F : grey;
    first = static_cast<int>(g + 0.5F);
    const float t = g - static_cast<float>(first);
    weight = {0.5F * (0.5F - t) * (0.5F - t), 0.75F - t * t, 0.5F * (0.5F + t) * (0.5F + t)};
    slope = {t - 0.5F, -2.0F * t, t + 0.5F};
  }
};

/// How often each code of a surface was met with each grey value.
class JointHistogram {
 public:
  void add(std::uint8_t code, const GreySpread& grey) {
    float* row = counts_.data() + static_cast<std::size_t>(code) * grey_bins + grey.first;
    row[0] += grey.weight[0];
    row[1] += grey.weight[1];
    row[2] += grey.weight[2];
  }
  JointHistogram& operator+=(const JointHistogram& other);

  /// The normalised information distance 1 - I / H of code and grey value: 0 where one tells the other, 1 where they
  /// have nothing in common (and where there is nothing at all).
  [[nodiscard]] double distance() const;
  /// Likewise with its derivative by each count, times the sum of all counts.
  double distance(std::vector<float>& by_count) const;
  [[nodiscard]] double total() const;

 private:
  struct Entropies;
  [[nodiscard]] Entropies entropies() const;

  std::array<float, static_cast<std::size_t>(surface_codes_count) * grey_bins> counts_{};
};

}  // namespace rigcal
