#include "core/records/pixel_format.h"

#include <array>
#include <utility>

namespace rigcal {

std::optional<PixelFormat> parse_pixel_format(std::string_view name) {
  if (name.empty()) return PixelFormat{};
  constexpr std::array<std::pair<std::string_view, PixelLayout>, 7> layouts{{
      {"Mono", PixelLayout::mono},
      {"BayerRG", PixelLayout::bayer_rg},
      {"BayerGR", PixelLayout::bayer_gr},
      {"BayerGB", PixelLayout::bayer_gb},
      {"BayerBG", PixelLayout::bayer_bg},
      {"RGB", PixelLayout::rgb},
      {"BGR", PixelLayout::bgr},
  }};
  constexpr std::array<std::pair<std::string_view, int>, 5> depths{
      {{"8", 8}, {"10", 10}, {"12", 12}, {"14", 14}, {"16", 16}}};
  for (const auto& [word, layout] : layouts) {
    if (!name.starts_with(word)) continue;
    for (const auto& [digits, bits] : depths) {
      if (name.substr(word.size()) == digits) return PixelFormat{layout, bits};
    }
  }
  return std::nullopt;
}

int bayer_colour(PixelLayout layout, int x, int y) {
  const bool red_row = layout == PixelLayout::bayer_rg || layout == PixelLayout::bayer_gr;
  const bool green_first = layout == PixelLayout::bayer_gr || layout == PixelLayout::bayer_gb;
  const bool odd_row = (y & 1) != 0;
  const bool odd_column = (x & 1) != 0;
  if ((odd_column == odd_row) == green_first) return 1;
  return red_row != odd_row ? 0 : 2;
}

}  // namespace rigcal
