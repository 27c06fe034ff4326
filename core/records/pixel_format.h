#pragma once

#include <optional>
#include <string_view>

namespace rigcal {

/// Which colour each pixel of a frame has. A Bayer layout is named by the first two pixels of the first row.
enum class PixelLayout { mono, bayer_rg, bayer_gr, bayer_gb, bayer_bg, rgb, bgr };

/// A pixel format of the GenICam naming convention (PFNC), uncompressed and unpacked.
struct PixelFormat {
  PixelLayout layout = PixelLayout::mono;
  int bits = 8;  ///< That carry the value: 8, 10, 12, 14 or 16; more than 8 stand in the low bits of 16.

  [[nodiscard]] int stored_bits() const { return bits == 8 ? 8 : 16; }
  [[nodiscard]] int channels() const { return layout == PixelLayout::rgb || layout == PixelLayout::bgr ? 3 : 1; }
};

/// "Mono8", "BayerRG12", "RGB8" and so on; nothing for any other name. An empty name is Mono8.
[[nodiscard]] std::optional<PixelFormat> parse_pixel_format(std::string_view name);

/// Colour of a pixel of a Bayer frame: 0 red, 1 green, 2 blue. `layout` must be one of the Bayer ones.
[[nodiscard]] int bayer_colour(PixelLayout layout, int x, int y);

}  // namespace rigcal
