// What `rigcal replay` makes of a recording: any datagrams from any addresses, at any pace. Nothing breaks, memory is
// bounded, and what was a sample packet stays one.
#include <algorithm>
#include <vector>

#include "apps/replay/recorded_devices.h"
#include "apps/replay/replay_stamps.h"
#include "core/base/error.h"

namespace {

using namespace rigcal;

void rewrite(ByteReader& script, const Datagram& datagram, ReplayStamps& stamps) {
  const auto pace = script.read<std::uint8_t>();
  const ReplayPace chosen{pace == 0 ? 1.0 : 0.01 + pace * 0.4, pace < 64 ? 0 : script.read<std::uint32_t>() * 1000LL};
  if (pace % 16 == 7) stamps.restart(pace * 1000);
  std::vector<std::uint8_t> packet(datagram.bytes.begin(), datagram.bytes.end());
  const bool was_packet = livox::parse_sample_packet(packet).has_value();
  stamps.rewrite(chosen, datagram.stamp_ns, packet);
  change_coordinates(pace % 2 == 0, packet);
  RIGCAL_ASSERT(livox::parse_sample_packet(packet).has_value() == was_packet, "a packet that is none any more");
}

}  // namespace

// The script: for each datagram a stamp (8 bytes), the last numbers of the address and of the port, its length (2), a
// byte or five for the pace, and the bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  ByteReader script(ByteView(bytes, size));
  RecordedDevices devices;
  ReplayStamps stamps;
  while (script.left() > 0) {
    Datagram datagram;
    datagram.stamp_ns = script.read<std::int64_t>();
    datagram.from = {{10, 0, 0, script.read<std::uint8_t>()}, script.read<std::uint8_t>()};
    const auto length = script.read<std::uint16_t>();
    datagram.bytes = script.take(std::min<std::size_t>(length, script.left()));
    const bool is_of_lidar = devices.add(datagram);
    if (is_of_lidar) rewrite(script, datagram, stamps);
    RIGCAL_ASSERT(devices.devices().size() <= RecordedDevices::kMost, "too many devices");
  }
  for (const auto& [ip, device] : devices.devices()) {
    RIGCAL_ASSERT(device.ports.size() <= RecordedDevices::kMostPorts, "too many ports");
    RIGCAL_ASSERT(identity_of(device, {}).broadcast.broadcast_code.size() == 15, "a code of another length");
  }
  return 0;
}
