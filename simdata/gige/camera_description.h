#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rigcal::sim {

/// The files that the build puts into the program: camera.xml, and in transport.xml the features that
/// only cameras on GigE Vision have here.
extern const std::string_view camera_xml;
extern const std::string_view transport_xml;

/// By what a camera is reached. Its features are the same, its names lie elsewhere.
enum class Transport : unsigned char { gige, usb3 };

/// Where a device on USB3 Vision keeps its names, each 64 bytes.
namespace usb3_names {
constexpr unsigned kManufacturer = 0x04;
constexpr unsigned kModel = 0x44;
constexpr unsigned kFamily = 0x84;
constexpr unsigned kVersion = 0xC4;
constexpr unsigned kInformation = 0x104;
constexpr unsigned kSerial = 0x144;
constexpr unsigned kUser = 0x184;
constexpr unsigned kBytes = 64;
}  // namespace usb3_names

// Limits that the description tells and the device keeps.
constexpr unsigned kShortestHeartbeatMs = 500;
constexpr unsigned kLongestHeartbeatMs = 600'000;
constexpr unsigned kSmallestPacket = 220;
constexpr unsigned kLargestPacket = 9156;
constexpr unsigned kPacketStep = 8;
constexpr unsigned kLongestPacketDelay = 10'000'000;  ///< Ticks.

/// What the virtual camera can do, as a GenICam description. `pixel_formats` are names that gige::pixel_code knows.
[[nodiscard]] std::string describe_camera(const std::vector<std::string>& pixel_formats,
                                          Transport transport = Transport::gige, double least_trigger_delay_us = 0.0);

}  // namespace rigcal::sim
