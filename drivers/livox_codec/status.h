#pragma once

#include <cstdint>
#include <string>

namespace rigcal::livox {

/// Two bits each; 3 is not defined but survives a round trip.
enum class Level : std::uint8_t { normal = 0, warning = 1, error = 2 };

enum class TimeSync : std::uint8_t {
  not_started = 0,
  ptp = 1,
  gps = 2,
  pps = 3,
  abnormal = 4,  ///< The source of highest priority failed.
};

/// The status word of a LiDAR (not of a Hub): in every sample packet, in heartbeat acks and in abnormal messages.
struct Status {
  Level temperature = Level::normal;
  Level voltage = Level::normal;
  Level motor = Level::normal;
  std::uint8_t dirty = 0;  ///< Two bits: 1 means dirty or blocked.
  bool firmware_abnormal = false;
  bool pps_ok = false;
  bool near_end_of_life = false;
  bool fan_warning = false;
  /// Raw: the vendor's header and page contradict each other on whether 1 means on or off.
  bool self_heating_bit = false;
  bool ptp_ok = false;
  TimeSync time_sync = TimeSync::not_started;  ///< Three bits.
  std::uint16_t reserved = 0;                  ///< Bits 17 to 29.
  Level system = Level::normal;

  bool operator==(const Status&) const = default;
};

/// What the device says its clock follows, in words: "synchronised by PTP".
[[nodiscard]] std::string sync_text(const Status& status);

/// Any word decodes, and encodes again to itself.
[[nodiscard]] Status decode_status(std::uint32_t word);
[[nodiscard]] std::uint32_t encode_status(const Status& status);

/// The status word of a Hub: in its heartbeat acks and abnormal messages.
struct HubStatus {
  std::uint8_t time_sync = 0;  ///< Two bits: 0 none, 1 PTP, 2 GPS, 3 abnormal.
  Level temperature = Level::normal;
  bool lidar_abnormal = false;
  bool lidar_link_changed = false;  ///< Ask for the list of LiDARs again.
  bool lidar_firmware_abnormal = false;
  std::uint32_t reserved = 0;  ///< Bits 7 to 29.
  Level system = Level::normal;

  bool operator==(const HubStatus&) const = default;
};

/// Any word decodes, and encodes again to itself.
[[nodiscard]] HubStatus decode_hub_status(std::uint32_t word);
[[nodiscard]] std::uint32_t encode_hub_status(const HubStatus& status);

/// The tag byte of a point.
struct Tag {
  std::uint8_t spatial_noise = 0;    ///< 0 normal; noise with high (1), moderate (2) or low (3) confidence.
  std::uint8_t intensity_noise = 0;  ///< 0 normal; noise with high (1) or moderate (2) confidence; 3 reserved.
  std::uint8_t return_number = 0;    ///< 0: merged with the reflection inside the sensor (nearer than about 1.5 m).
  std::uint8_t stray_light = 0;      ///< Mid-70: 1 distorted by light nearby; reserved elsewhere.

  bool operator==(const Tag&) const = default;
};

[[nodiscard]] constexpr Tag decode_tag(std::uint8_t byte) {
  return {static_cast<std::uint8_t>(byte & 3U), static_cast<std::uint8_t>((byte >> 2U) & 3U),
          static_cast<std::uint8_t>((byte >> 4U) & 3U), static_cast<std::uint8_t>(byte >> 6U)};
}

[[nodiscard]] constexpr std::uint8_t encode_tag(const Tag& tag) {
  return static_cast<std::uint8_t>((tag.spatial_noise & 3U) | ((tag.intensity_noise & 3U) << 2U) |
                                   ((tag.return_number & 3U) << 4U) | ((tag.stray_light & 3U) << 6U));
}

/// True where the sensor itself takes the point for noise with high or moderate confidence.
[[nodiscard]] constexpr bool is_noise(const Tag& tag) {
  return tag.spatial_noise == 1 || tag.spatial_noise == 2 || tag.intensity_noise == 1 || tag.intensity_noise == 2;
}

}  // namespace rigcal::livox
