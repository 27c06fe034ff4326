#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rigcal::sim {

/// The file that the build puts into the program (see camera.xml).
extern const std::string_view camera_xml;

// Limits that the description tells and the device keeps.
constexpr unsigned kShortestHeartbeatMs = 500;
constexpr unsigned kLongestHeartbeatMs = 600'000;
constexpr unsigned kSmallestPacket = 220;
constexpr unsigned kLargestPacket = 9156;
constexpr unsigned kPacketStep = 8;
constexpr unsigned kLongestPacketDelay = 10'000'000;  ///< Ticks.

/// What the virtual camera can do, as a GenICam description. `pixel_formats` are names that gige::pixel_code knows.
[[nodiscard]] std::string describe_camera(const std::vector<std::string>& pixel_formats);

}  // namespace rigcal::sim
