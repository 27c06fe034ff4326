#include "apps/recording/image_mean.h"

namespace rigcal {
namespace {

std::uint32_t value_of(const Image& image, std::size_t i) {
  if (image.bits == 8) return image.bytes[i];
  return static_cast<std::uint32_t>(image.bytes[2 * i] | image.bytes[2 * i + 1] << 8);
}

}  // namespace

bool ImageMean::add(const Image& image) {
  constexpr int most = 65536;  // as many 16 bit values fit into a sum
  if (count_ == 0) {
    first_ = image;
    count_ = 1;
    return true;
  }
  if (image.width != first_.width || image.height != first_.height || image.channels != first_.channels ||
      image.bits != first_.bits)
    return false;
  if (count_ == most) return true;
  const std::size_t values = image.bytes.size() / static_cast<std::size_t>(image.bits / 8);
  if (sums_.empty()) {
    sums_.resize(values);
    for (std::size_t i = 0; i < values; ++i) sums_[i] = value_of(first_, i);
  }
  for (std::size_t i = 0; i < values; ++i) sums_[i] += value_of(image, i);
  ++count_;
  return true;
}

Image ImageMean::mean() const {
  Image out = first_;
  const auto count = static_cast<std::uint32_t>(count_);
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const std::uint32_t value = (sums_[i] + count / 2) / count;
    if (out.bits == 8) {
      out.bytes[i] = static_cast<std::uint8_t>(value);
    } else {
      out.bytes[2 * i] = static_cast<std::uint8_t>(value & 0xFFU);
      out.bytes[2 * i + 1] = static_cast<std::uint8_t>(value >> 8U);
    }
  }
  return out;
}

}  // namespace rigcal
