#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace rigcal::gige {

/// The number of a pixel format of the GenICam naming convention on the wire, for example 0x01080009 for "BayerRG8".
/// Nothing for formats that are packed or not known (see core/records/pixel_format.h).
[[nodiscard]] std::optional<std::uint32_t> pixel_code(std::string_view name);

/// The name of a number; empty where there is none.
[[nodiscard]] std::string_view pixel_name(std::uint32_t code);

/// How many bits a pixel takes on the wire: part of the number.
[[nodiscard]] constexpr std::uint32_t bits_of_pixel(std::uint32_t code) { return (code >> 16U) & 0xFFU; }

}  // namespace rigcal::gige
