#pragma once

#include <algorithm>
#include <string>

#include "core/base/text.h"

namespace rigcal {

/// What the intensities of clouds were before each was rounded to 0 .. 255: of other scales nothing is left of them.
struct IntensityRange {
  double largest = 0.0;
  bool has_fractions = false;  ///< One between 0 and 1.

  void add(double value) {
    largest = value > largest ? value : largest;
    has_fractions |= value > 0.0 && value < 1.0;
  }
  void add(const IntensityRange& other) {
    largest = std::max(largest, other.largest);
    has_fractions |= other.has_fractions;
  }
  /// What is wrong with the scale, and the mend: a clause; empty where nothing is.
  [[nodiscard]] std::string complaint() const {
    constexpr double most = 255.0;
    if (largest > most + 0.5) {
      return "intensities reach " + fixed_text(largest, 0) + ", and all above 255 count as 255; scale them to 0..255";
    }
    if (has_fractions && largest <= 1.0) {
      return "intensities are at most " + fixed_text(largest, 2) +
             ", and of their fractions nothing is left; scale them to 0..255";
    }
    return {};
  }
};

}  // namespace rigcal
