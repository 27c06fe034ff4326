#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace rigcal {

/// Pixels in memory: rows from the top without gaps, channels next to each other (colour is red, green, blue), 16 bit
/// values low byte first. Frames of a Bayer sensor have one channel.
struct Image {
  int width = 0;
  int height = 0;
  int channels = 1;          ///< 1 or 3.
  int bits = 8;              ///< Of a channel in memory: 8 or 16.
  std::string pixel_format;  ///< What the values mean, as the rig file says it ("BayerRG8"); may be empty.
  std::vector<std::uint8_t> bytes;

  [[nodiscard]] std::size_t row_bytes() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(channels) * static_cast<std::size_t>(bits / 8);
  }
  /// Whether the sizes are sane and agree with each other.
  [[nodiscard]] bool is_consistent() const {
    return width > 0 && height > 0 && (channels == 1 || channels == 3) && (bits == 8 || bits == 16) &&
           bytes.size() == row_bytes() * static_cast<std::size_t>(height);
  }
  /// The value of a channel; the place must lie in a consistent image.
  [[nodiscard]] int at(int x, int y, int channel = 0) const {
    const std::size_t value =
        static_cast<std::size_t>(x) * static_cast<std::size_t>(channels) + static_cast<std::size_t>(channel);
    const std::uint8_t* row = bytes.data() + static_cast<std::size_t>(y) * row_bytes();
    return bits == 8 ? row[value] : row[2 * value] | row[2 * value + 1] << 8;
  }
};

/// What is known of one image of a camera: a line of frames.csv.
struct FrameRecord {
  std::string file;                     ///< Name in the camera's folder.
  std::int64_t stamp_ns = 0;            ///< Middle of the exposure, session time.
  std::optional<std::int64_t> trigger;  ///< Number of the pulse that released it.
  std::optional<double> exposure_us;
  std::optional<std::int64_t> device_stamp;  ///< Of the camera's own clock, in its own unit.
  std::optional<int> stop;                   ///< A remark: what counts is where the stamp lies.
};

/// A pulse on the trigger line: a line of trigger.csv.
struct TriggerPulse {
  std::int64_t pulse = 0;
  std::int64_t stamp_ns = 0;  ///< Of its leading edge, session time.
};

/// Where the turntable says it was: a line of turntable.csv.
struct TableAngle {
  std::int64_t stamp_ns = 0;  ///< Session time.
  double angle_deg = 0.0;     ///< Right-handed about the rig's axis, from wherever the table counts.
};

}  // namespace rigcal
