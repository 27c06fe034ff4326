#include "drivers/gige_codec/bootstrap.h"

#include <algorithm>

#include "core/base/network_order.h"

namespace rigcal::gige {
namespace {

constexpr std::size_t long_text = 32;
constexpr std::size_t information_text = 48;
constexpr std::size_t short_text = 16;

std::string read_text(ByteReader& reader, std::size_t size) {
  const ByteView field = reader.take(size);
  return {field.begin(), std::find(field.begin(), field.end(), std::uint8_t{0})};
}

template <std::size_t size>
void take(ByteReader& reader, std::array<std::uint8_t, size>& out) {
  const ByteView view = reader.take(size);
  std::copy(view.begin(), view.end(), out.begin());
}

}  // namespace

Expected<DeviceIdentity> decode_identity(ByteView bytes) {
  ByteReader reader(bytes);
  DeviceIdentity identity;
  identity.version_major = read_network<std::uint16_t>(reader);
  identity.version_minor = read_network<std::uint16_t>(reader);
  identity.device_mode = read_network<std::uint32_t>(reader);
  static_cast<void>(reader.take(2));
  take(reader, identity.mac);
  identity.ip_options = read_network<std::uint32_t>(reader);
  identity.ip_configuration = read_network<std::uint32_t>(reader);
  for (Ipv4* ip : {&identity.ip, &identity.mask, &identity.gateway}) {
    static_cast<void>(reader.take(12));
    take(reader, *ip);
  }
  identity.manufacturer = read_text(reader, long_text);
  identity.model = read_text(reader, long_text);
  identity.device_version = read_text(reader, long_text);
  identity.information = read_text(reader, information_text);
  identity.serial = read_text(reader, short_text);
  identity.user_name = read_text(reader, short_text);
  if (!reader.ok()) {
    return input_error("a device tells of itself in " + std::to_string(DeviceIdentity::kBytes) + " bytes, not in " +
                           std::to_string(bytes.size()),
                       "a GigE Vision identity");
  }
  return identity;
}

std::vector<std::uint8_t> encode_identity(const DeviceIdentity& identity) {
  std::vector<std::uint8_t> out;
  ByteWriter writer(out);
  write_network(writer, identity.version_major);
  write_network(writer, identity.version_minor);
  write_network(writer, identity.device_mode);
  writer.write_text({}, 2);
  writer.write_bytes(identity.mac);
  write_network(writer, identity.ip_options);
  write_network(writer, identity.ip_configuration);
  for (const Ipv4& ip : {identity.ip, identity.mask, identity.gateway}) {
    writer.write_text({}, 12);
    writer.write_bytes(ip);
  }
  const auto write_text = [&writer](std::string_view text, std::size_t size) {
    writer.write_text(text.substr(0, size - 1), size);
  };
  write_text(identity.manufacturer, long_text);
  write_text(identity.model, long_text);
  write_text(identity.device_version, long_text);
  write_text(identity.information, information_text);
  write_text(identity.serial, short_text);
  write_text(identity.user_name, short_text);
  RIGCAL_ASSERT(out.size() == DeviceIdentity::kBytes, "an identity of another length");
  return out;
}

}  // namespace rigcal::gige
