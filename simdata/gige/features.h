#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace rigcal::sim {

/// The virtual camera's own registers, four bytes each; reals are IEEE 754 of 32 bits.
enum class Feature : std::uint8_t {
  // Settings; user sets keep these.
  width,
  height,
  offset_x,
  offset_y,
  pixel_format,  ///< The number on the wire, see gige::pixel_code.
  acquisition_mode,
  acquisition_frame_count,
  frame_rate,
  frame_rate_enable,
  trigger_mode,
  trigger_source,
  trigger_activation,
  trigger_delay,
  exposure_auto,
  exposure_time,
  gain,
  chunk_mode,
  chunk_enable,  ///< One of each chunk.
  line_mode,     ///< This and the next three: one of each line.
  strobe_enable,
  strobe_duration,
  strobe_delay,
  // What is no setting.
  user_set_default,
  width_max,
  height_max,
  payload_size,
  locked,
  trigger_selector,
  chunk_selector,
  line_selector,
  user_set_selector,
  resulting_frame_rate,
  temperature,
  acquisition_start,
  acquisition_stop,
  trigger_software,
  user_set_load,
  user_set_save,
  device_reset,
};
constexpr Feature kLastSetting = Feature::strobe_delay;
constexpr Feature kLastFeature = Feature::device_reset;

// Values of enumerations.
enum class AcquisitionMode : std::uint32_t { continuous = 0, single_frame = 1, multi_frame = 2 };
constexpr std::uint32_t kSoftwareTrigger = 7;  ///< As `trigger_source`; smaller numbers are lines.
enum class TriggerActivation : std::uint32_t { rising = 0, falling = 1 };
enum class ExposureAuto : std::uint32_t { off = 0, once = 1, continuous = 2 };
enum class LineMode : std::uint32_t { input = 0, strobe = 8 };
enum class ChunkKind : std::uint8_t { frame_id, timestamp, exposure_time, gain };
constexpr std::uint32_t kChunks = 4;
constexpr std::uint32_t kLines = 3;  ///< Line 0 is an input, line 1 an output, line 2 either.

/// Numbers of chunks in a block.
constexpr std::uint32_t kImageChunk = 0x1000;
[[nodiscard]] constexpr std::uint32_t chunk_id(ChunkKind kind) {
  return kImageChunk + 1U + static_cast<std::uint32_t>(kind);
}

/// What a feature is, for the registers and for their description alike.
struct FeatureInfo {
  enum class Kind : std::uint8_t { integer, real, command };
  std::string_view name;  ///< Of the register in the description.
  Kind kind = Kind::integer;
  bool is_writable = true;
  bool is_locked_while_acquiring = false;
  std::uint32_t count = 1;    ///< Registers, one after the other,
  std::string_view selector;  ///< chosen by this register.
  double least = 0.0;
  double most = 0.0;
  double usual = 0.0;
};
[[nodiscard]] const FeatureInfo& info_of(Feature feature);

constexpr std::uint32_t kFirstFeatureAddress = 0xA000;
constexpr std::uint32_t kFeatureStride = 16;
[[nodiscard]] constexpr std::uint32_t address_of(Feature feature, std::uint32_t index = 0) {
  return kFirstFeatureAddress + kFeatureStride * static_cast<std::uint32_t>(feature) + 4 * index;
}

}  // namespace rigcal::sim
