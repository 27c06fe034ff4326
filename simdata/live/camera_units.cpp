#include "simdata/live/camera_units.h"

#include <algorithm>

#include "core/records/pixel_format.h"
#include "drivers/gige_codec/pixel_code.h"
#include "simdata/packets/sim_device.h"

namespace rigcal::sim {
namespace {

constexpr std::uint8_t first_address = 31;
constexpr std::size_t longest_serial = 15;

}  // namespace

bool is_served(const Sensor& sensor) {
  return !sensor.is_lidar() && sensor.camera->driver == "aravis" && sensor.camera->intrinsics.has_value();
}

Expected<std::vector<gige::Ipv4>> camera_addresses(const Rig& rig) {
  const auto host = host_address(rig);
  if (!host) return host.error();
  std::vector<gige::Ipv4> taken{*host};
  for (const Sensor& sensor : rig.sensors) {
    if (sensor.is_lidar() && sensor.lidar->ip) taken.push_back(*sensor.lidar->ip);
  }
  const auto is_taken = [&taken](const gige::Ipv4& ip) {
    return std::find(taken.begin(), taken.end(), ip) != taken.end();
  };
  std::vector<gige::Ipv4> addresses(rig.sensors.size());
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    if (!is_served(rig.sensors[i])) continue;
    const auto said = parse_ip(rig.sensors[i].camera->device);
    if (!said) continue;
    if (is_taken(*said))
      return input_error("sensor '" + rig.sensors[i].name + "' has the address of another one",
                         to_string(*said) + " in the rig", "give every sensor its own");
    taken.push_back(*said);
    addresses[i] = *said;
  }
  gige::Ipv4 next = *host;
  next[3] = first_address;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    if (!is_served(rig.sensors[i]) || addresses[i] != gige::Ipv4{}) continue;
    while (is_taken(next)) ++next[3];
    taken.push_back(next);
    addresses[i] = next;
  }
  return addresses;
}

gige::DeviceIdentity camera_identity(const Sensor& sensor, const gige::Ipv4& ip) {
  gige::DeviceIdentity identity;
  identity.mac = {0x02, 'r', ip[0], ip[1], ip[2], ip[3]};  // One of those that anybody may make up.
  identity.ip = ip;
  identity.mask = ip[0] == 127 ? gige::Ipv4{255, 0, 0, 0} : gige::Ipv4{255, 255, 255, 0};
  identity.device_version = "1.0";
  identity.information = "simulated by rigcal";
  identity.user_name = sensor.name;
  const std::string& device = sensor.camera->device;
  const std::size_t first = device.find('-');
  const std::size_t last = device.rfind('-');
  const bool is_named = first != last && device.size() - last - 1 <= longest_serial;
  identity.manufacturer = is_named ? device.substr(0, first) : "rigcal";
  identity.model = is_named ? device.substr(first + 1, last - first - 1) : "VirtualCamera";
  identity.serial = is_named ? device.substr(last + 1) : sensor.name;
  return identity;
}

Expected<std::vector<std::string>> camera_formats(const Sensor& sensor) {
  const std::string own = sensor.camera->pixel_format.empty() ? "Mono8" : sensor.camera->pixel_format;
  if (!gige::pixel_code(own))
    return input_error("the pixel format '" + own + "' has no number in GigE Vision",
                       "sensor '" + sensor.name + "' of the rig", "use 8, 10, 12 or 16 bits, for example BayerRG12");
  std::vector<std::string> formats{own};
  const std::string colours = own.substr(0, own.find_first_of("0123456789"));
  for (const std::string& layout : {colours, std::string("Mono")}) {
    for (const char* bits : {"8", "10", "12"}) {
      const std::string name = layout + bits;
      const bool known = gige::pixel_code(name).has_value() && parse_pixel_format(name).has_value();
      if (known && std::find(formats.begin(), formats.end(), name) == formats.end()) formats.push_back(name);
    }
  }
  return formats;
}

}  // namespace rigcal::sim
