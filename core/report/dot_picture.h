#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace rigcal {

/// A picture of many dots on a dark ground: where more of them fall a pixel is brighter, and where those of several
/// colours do it has their mean.
class DotPicture {
 public:
  DotPicture(int width, int height);

  /// A dot of two by two pixels around x (to the right) and y (downwards), in pixels; what is outside is left out.
  void dot(double x, double y, const std::array<std::uint8_t, 3>& rgb);
  /// A PNG file's bytes.
  [[nodiscard]] std::vector<std::uint8_t> png() const;

 private:
  void paint(double x, double y, const std::array<std::uint8_t, 3>& rgb);

  struct Pixel {
    std::array<std::uint32_t, 3> sum{};
    std::uint32_t count = 0;
  };
  int width_;
  int height_;
  std::uint64_t painted_ = 0;
  std::vector<Pixel> pixels_;
};

}  // namespace rigcal
