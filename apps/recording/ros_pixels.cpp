#include "apps/recording/ros_pixels.h"

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "core/io/image_file.h"

namespace rigcal {
namespace {

struct Encoding {
  std::string_view name;  ///< Of sensor_msgs/image_encodings.h.
  int channels;
  int bits;
  bool blue_first;
};

constexpr std::array<Encoding, 16> encodings{{{"mono8", 1, 8, false},
                                              {"mono16", 1, 16, false},
                                              {"8UC1", 1, 8, false},
                                              {"16UC1", 1, 16, false},
                                              {"rgb8", 3, 8, false},
                                              {"bgr8", 3, 8, true},
                                              {"8UC3", 3, 8, true},
                                              {"rgb16", 3, 16, false},
                                              {"bgr16", 3, 16, true},
                                              {"16UC3", 3, 16, true},
                                              {"rgba8", 4, 8, false},
                                              {"bgra8", 4, 8, true},
                                              {"8UC4", 4, 8, true},
                                              {"rgba16", 4, 16, false},
                                              {"bgra16", 4, 16, true},
                                              {"16UC4", 4, 16, true}}};

Expected<Image> copy_pixels(const PixelView& pixels) {
  constexpr std::uint64_t max_pixels = 100'000'000;
  const std::uint64_t value = static_cast<std::uint64_t>(pixels.bits / 8);
  const std::uint64_t row = pixels.width * static_cast<std::uint64_t>(pixels.channels) * value;
  const std::uint64_t count = static_cast<std::uint64_t>(pixels.width) * pixels.height;
  if (count == 0 || count > max_pixels || pixels.step < row ||
      pixels.data.size() < pixels.step * (pixels.height - 1ULL) + row) {
    return input_error("its size contradicts its bytes");
  }
  Image image;
  image.width = static_cast<int>(pixels.width);
  image.height = static_cast<int>(pixels.height);
  image.channels = pixels.channels == 1 ? 1 : 3;
  image.bits = pixels.bits;
  image.bytes.resize(image.row_bytes() * pixels.height);
  std::size_t out = 0;
  for (std::size_t y = 0; y < pixels.height; ++y) {
    const ByteView line = pixels.data.subspan(y * pixels.step, row);
    for (std::size_t x = 0; x < pixels.width; ++x) {
      for (int c = 0; c < image.channels; ++c) {
        const int from = pixels.blue_first && image.channels == 3 ? 2 - c : c;
        const std::size_t at = (x * static_cast<std::size_t>(pixels.channels) + static_cast<std::size_t>(from)) * value;
        const bool swap = pixels.big_endian && value == 2;
        for (std::size_t k = 0; k < value; ++k) image.bytes[out++] = line[at + (swap ? 1 - k : k)];
      }
    }
  }
  return image;
}

std::string with_bits(std::string format, int bits) {
  while (!format.empty() && format.back() >= '0' && format.back() <= '9') format.pop_back();
  return format.empty() ? format : format + std::to_string(bits);
}

}  // namespace

std::optional<PixelView> pixels_of(const RosImage& image) {
  for (const Encoding& known : encodings) {
    if (image.encoding != known.name) continue;
    return PixelView{image.width,      image.height,     known.channels, known.bits,
                     known.blue_first, image.big_endian, image.step,     image.data};
  }
  const bool bayer = image.encoding.starts_with("bayer_");
  const bool deep = image.encoding.ends_with("16");
  if (!bayer || (!deep && !image.encoding.ends_with("8"))) return std::nullopt;
  return PixelView{image.width, image.height, 1, deep ? 16 : 8, false, image.big_endian, image.step, image.data};
}

std::string bayer_format(const RosImage& image) {
  // Of a compressed image: "bayer_rggb8; png compressed ", and the encoding that it had been turned into.
  const std::string_view format = image.encoding;
  const std::string_view raw = format.substr(0, format.find(';'));
  constexpr std::string_view mark = "compressed";
  const std::size_t at = format.find(mark, raw.size());
  if (at != std::string_view::npos) {
    const std::string_view turned = format.substr(at + mark.size());
    const std::size_t first = turned.find_first_not_of(' ');
    if (first != std::string_view::npos && !turned.substr(first).starts_with("bayer_")) return {};
  }
  // sensor_msgs names them by the first two rows of the filter.
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> layouts{
      {{"bayer_rggb", "BayerRG"}, {"bayer_grbg", "BayerGR"}, {"bayer_gbrg", "BayerGB"}, {"bayer_bggr", "BayerBG"}}};
  for (const auto& [encoding, name] : layouts) {
    if (raw.starts_with(encoding)) return std::string(name) + std::string(raw.substr(encoding.size()));
  }
  return {};
}

Expected<Image> image_of(RosType type, const RosImage& image) {
  if (type == RosType::compressed_image) {
    Expected<Image> out = decode_image(image.data, {});
    // Pixels in colours are no mosaic any more; those of 16 bits may have become 8.
    if (out && out->channels == 1) out->pixel_format = with_bits(bayer_format(image), out->bits);
    return out;
  }
  const std::optional<PixelView> pixels = pixels_of(image);
  if (!pixels) return input_error("its encoding '" + image.encoding.substr(0, 40) + "' is not known");
  Expected<Image> out = copy_pixels(*pixels);
  if (out) out->pixel_format = bayer_format(image);
  return out;
}

}  // namespace rigcal
