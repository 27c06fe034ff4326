// Packets on the control endpoint of the virtual USB3 Vision camera, one after the other: each begins with its length.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "simdata/usb3/usb3_camera.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rigcal;
  sim::VirtualCameraOptions options;
  options.identity.serial = "00F12345678";
  std::int64_t now_ns = 1'000'000'000;
  sim::usb3::Usb3Camera camera(options, now_ns);
  std::vector<sim::FrameOrder> frames;
  ByteReader reader(ByteView(data, size));
  while (reader.left() > 2) {
    const auto length = reader.read<std::uint16_t>();
    const ByteView packet = reader.take(std::min<std::size_t>(length, reader.left()));
    const std::vector<std::uint8_t> answer = camera.receive(now_ns, packet);
    RIGCAL_ASSERT(answer.size() <= sim::usb3::kMaxControlBytes, "an answer longer than the host was told");
    now_ns += 1'000'000;
    frames.clear();
    camera.tick(now_ns, frames);
  }
  return 0;
}
