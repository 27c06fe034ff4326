#pragma once

#include <cstdint>
#include <vector>

#include "core/records/image.h"

namespace rigcal {

/// The mean of images of one size and kind, pixel by pixel.
class ImageMean {
 public:
  /// False, and nothing is added, where it has another size, depth or number of channels than the first one.
  [[nodiscard]] bool add(const Image& image);
  [[nodiscard]] int count() const { return count_; }
  /// The mean, rounded; at least one image must have been added.
  [[nodiscard]] Image mean() const;

 private:
  Image first_;
  std::vector<std::uint32_t> sums_;  ///< Empty until there is a second one.
  int count_ = 0;
};

}  // namespace rigcal
