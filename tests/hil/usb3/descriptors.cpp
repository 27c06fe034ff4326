#include "tests/hil/usb3/descriptors.h"

#include "core/base/bytes.h"

namespace rigcal::hil {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t device_type = 0x01;
constexpr std::uint8_t configuration_type = 0x02;
constexpr std::uint8_t string_type = 0x03;
constexpr std::uint8_t capabilities_type = 0x0F;
constexpr std::uint16_t vendor = 0x2BDF;  // Hikrobot
constexpr std::uint16_t product = 0x0001;
constexpr std::uint8_t miscellaneous = 0xEF;
constexpr std::uint8_t usb3_vision = 0x05;

enum StringIndex : std::uint8_t { languages, manufacturer_name, product_name, serial_name, guid_name };

void append(Bytes& to, const Bytes& bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

Bytes device() {
  return {18,
          device_type,
          0x00,
          0x03,
          miscellaneous,
          2,
          1,
          9,
          vendor & 0xFFU,
          vendor >> 8U,
          product & 0xFFU,
          product >> 8U,
          0x00,
          0x01,
          manufacturer_name,
          product_name,
          serial_name,
          1};
}

Bytes endpoint(std::uint8_t address) {
  Bytes bytes = endpoint_descriptor(address);
  append(bytes, {6, 0x30, 0, 0, 0, 0});  // SuperSpeed companion: no bursts.
  return bytes;
}

Bytes interface(std::uint8_t number, std::uint8_t endpoints, std::uint8_t protocol) {
  return {9, 0x04, number, 0, endpoints, miscellaneous, usb3_vision, protocol, 0};
}

// Class-specific: versions of GenCP (1.1) and USB3 Vision (1.0), texts, speeds.
Bytes camera() {
  return {20,           0x24,         0x01, 1, 0,           1, 0,   0, 0, 1, 0, guid_name, manufacturer_name,
          product_name, product_name, 0,    0, serial_name, 0, 0x08};
}

Bytes configuration() {
  Bytes body{8, 0x0B, 0, 2, miscellaneous, usb3_vision, 0, 0};  // The two interfaces belong together.
  append(body, interface(0, 2, 0x00));
  append(body, camera());
  append(body, endpoint(kControlIn));
  append(body, endpoint(kControlOut));
  append(body, interface(1, 1, 0x02));
  append(body, endpoint(kStreamIn));
  const std::size_t total = body.size() + 9;
  Bytes bytes{9,
              configuration_type,
              static_cast<std::uint8_t>(total & 0xFFU),
              static_cast<std::uint8_t>(total >> 8U),
              2,
              1,
              0,
              0xC0,
              0x32};
  append(bytes, body);
  return bytes;
}

// USB 2 link power management, and SuperSpeed at full, high and super speed.
Bytes capabilities() {
  return {5,   capabilities_type, 22, 0, 2, 7, 0x10, 0x02, 0x02, 0, 0, 0, 10, 0x10, 0x03, 0, 0x0E, 0, 1, 0x0A, 0xFF,
          0x07};
}

std::optional<Bytes> text(std::uint8_t index, const UsbNames& names) {
  const std::string* const texts[] = {nullptr, &names.manufacturer, &names.product, &names.serial, &names.guid};
  if (index == languages) return Bytes{4, string_type, 0x09, 0x04};
  if (index > guid_name) return std::nullopt;
  Bytes bytes{static_cast<std::uint8_t>(2 + 2 * texts[index]->size()), string_type};
  for (const char letter : *texts[index]) append(bytes, {static_cast<std::uint8_t>(letter), 0});
  return bytes;
}

}  // namespace

Bytes endpoint_descriptor(std::uint8_t address) { return {7, 0x05, address, 0x02, 0x00, 0x04, 0}; }

std::optional<Bytes> descriptor(std::uint8_t type, std::uint8_t index, const UsbNames& names) {
  switch (type) {
    case device_type:
      return device();
    case configuration_type:
      return configuration();
    case string_type:
      return text(index, names);
    case capabilities_type:
      return capabilities();
    default:
      return std::nullopt;
  }
}

}  // namespace rigcal::hil
