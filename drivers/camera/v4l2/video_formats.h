#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace rigcal::camera {

/// The GenICam name of a pixel format of Video4Linux, "BayerRG10" for RG10; empty for those that rigcal does not read
/// (packed, compressed, YUV).
[[nodiscard]] std::string_view name_of_fourcc(std::uint32_t fourcc);
/// And back; 0 where there is none.
[[nodiscard]] std::uint32_t fourcc_of(std::string_view name);

}  // namespace rigcal::camera
