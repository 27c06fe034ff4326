#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace rigcal::camera {

/// Who made a camera, as far as its features have names of their own.
enum class Vendor : std::uint8_t { generic, hikrobot, basler, flir };
[[nodiscard]] Vendor vendor_of(std::string_view vendor_name);

/// What has different names. The names of the Standard Features Naming Convention that all agree on stand where they
/// are used.
enum class Purpose : std::uint8_t {
  exposure,              ///< Microseconds.
  gain,                  ///< dB, or the camera's own steps.
  frame_rate,            ///< Frames per second.
  frame_rate_enable,     ///< Whether `frame_rate` counts.
  frame_rate_auto,       ///< To be turned off.
  trigger_delay,         ///< Microseconds.
  trigger_delay_enable,  ///< Whether `trigger_delay` counts.
  ptp,                   ///< Clocks by IEEE 1588.
  strobe_mode,           ///< Of LineMode: the line shows something.
  strobe_source,         ///< Of LineSource: it shows the exposure.
  strobe_enable,         ///< A switch for it.
  chunk_of_exposure,     ///< Of ChunkSelector.
  chunk_exposure,        ///< The feature that is read from a frame.
};
constexpr Purpose kLastPurpose = Purpose::chunk_exposure;

/// The names to be looked for, the vendor's own first, the others' behind: firmwares change.
[[nodiscard]] std::vector<std::string_view> names_of(Purpose purpose, Vendor vendor);

}  // namespace rigcal::camera
