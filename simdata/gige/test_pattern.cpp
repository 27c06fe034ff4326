#include "simdata/gige/test_pattern.h"

#include <algorithm>

#include "core/records/pixel_format.h"

namespace rigcal::sim {

bool TestPattern::make(const FrameWish& wish, std::vector<std::uint8_t>& out) {
  const PixelFormat format = parse_pixel_format(wish.pixel_format).value_or(PixelFormat{});
  const auto channels = static_cast<std::size_t>(format.channels());
  const std::size_t bytes = static_cast<std::size_t>(format.stored_bits()) / 8;
  const auto width = static_cast<std::size_t>(wish.width);
  const std::size_t row_bytes = width * channels * bytes;
  out.resize(row_bytes * static_cast<std::size_t>(wish.height));
  // Every row is a part of one long row, which comes again after as many values as the format has.
  const std::size_t period = std::size_t{1} << static_cast<unsigned>(format.bits);
  std::vector<std::uint8_t> values((period + width) * channels * bytes);
  for (std::size_t i = 0; i < values.size() / bytes; ++i) {
    const std::size_t value = i / channels % period;
    values[i * bytes] = static_cast<std::uint8_t>(value);
    if (bytes == 2) values[i * bytes + 1] = static_cast<std::uint8_t>(value >> 8U);
  }
  for (int y = 0; y < wish.height; ++y) {
    const std::size_t first = value(wish.number, wish.offset_x, wish.offset_y + y, format.bits);
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(first * channels * bytes), row_bytes,
                out.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * row_bytes));
  }
  return true;
}

}  // namespace rigcal::sim
