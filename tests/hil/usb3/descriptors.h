#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What a USB3 Vision camera says of itself when it is plugged in (USB 3.2, 9.6; USB3 Vision 1.0, 3).
namespace rigcal::hil {

struct UsbNames {
  std::string manufacturer;
  std::string product;
  std::string serial;
  std::string guid;  ///< 12 letters: the vendor's number and its own.
};

inline constexpr std::uint8_t kControlOut = 0x01;
inline constexpr std::uint8_t kControlIn = 0x81;
inline constexpr std::uint8_t kStreamIn = 0x82;

/// `type` and `index` of a GET_DESCRIPTOR request; nothing where there is none.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> descriptor(std::uint8_t type, std::uint8_t index,
                                                                  const UsbNames& names);
/// Of a bulk endpoint, with the largest packets of SuperSpeed.
[[nodiscard]] std::vector<std::uint8_t> endpoint_descriptor(std::uint8_t address);

}  // namespace rigcal::hil
