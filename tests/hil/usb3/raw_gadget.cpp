#include "tests/hil/usb3/raw_gadget.h"

#include <fcntl.h>
#include <linux/usb/ch9.h>
#include <linux/usb/raw_gadget.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace rigcal::hil {
namespace {

constexpr std::size_t packet_of_endpoint_0 = 512;  // SuperSpeed.
constexpr std::size_t largest_setup = 4096;

Error refused(const char* what) {
  return system_error(std::string(what) + ": " + std::strerror(errno), "/dev/raw-gadget",
                      "run this in the virtual machine: tests/hil/run");
}

// The kernel's structure with its bytes behind it.
std::vector<std::uint8_t> transfer(int endpoint, std::uint16_t flags, std::size_t length, ByteView bytes) {
  std::vector<std::uint8_t> memory(sizeof(usb_raw_ep_io) + length);
  const auto number = static_cast<std::uint16_t>(endpoint);
  const auto size = static_cast<std::uint32_t>(length);
  std::memcpy(memory.data() + offsetof(usb_raw_ep_io, ep), &number, sizeof number);
  std::memcpy(memory.data() + offsetof(usb_raw_ep_io, flags), &flags, sizeof flags);
  std::memcpy(memory.data() + offsetof(usb_raw_ep_io, length), &size, sizeof size);
  std::copy(bytes.begin(), bytes.end(), memory.begin() + sizeof(usb_raw_ep_io));
  return memory;
}

}  // namespace

Expected<std::unique_ptr<RawGadget>> RawGadget::plug_in() {
  const int descriptor = open("/dev/raw-gadget", O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return refused("no raw gadget");
  std::unique_ptr<RawGadget> gadget(new RawGadget(descriptor));
  usb_raw_init init{};
  std::strcpy(reinterpret_cast<char*>(init.driver_name), "dummy_udc");
  std::strcpy(reinterpret_cast<char*>(init.device_name), "dummy_udc.0");
  init.speed = USB_SPEED_SUPER;
  if (ioctl(descriptor, USB_RAW_IOCTL_INIT, &init) != 0) return refused("the dummy host cannot be had");
  if (ioctl(descriptor, USB_RAW_IOCTL_RUN, 0) != 0) return refused("the device cannot be plugged in");
  return gadget;
}

RawGadget::~RawGadget() { close(descriptor_); }

Expected<std::optional<SetupRequest>> RawGadget::next() {
  std::array<std::uint8_t, sizeof(usb_raw_event) + largest_setup> memory{};
  const auto length = static_cast<std::uint32_t>(largest_setup);
  std::memcpy(memory.data() + offsetof(usb_raw_event, length), &length, sizeof length);
  if (ioctl(descriptor_, USB_RAW_IOCTL_EVENT_FETCH, memory.data()) != 0) {
    if (errno == EINTR) return std::optional<SetupRequest>();
    return refused("no more requests");
  }
  ByteReader reader(memory);
  const auto type = reader.read<std::uint32_t>();
  static_cast<void>(reader.read<std::uint32_t>());
  if (type != USB_RAW_EVENT_CONTROL) return std::optional<SetupRequest>();
  SetupRequest request;
  request.type = reader.read<std::uint8_t>();
  request.request = reader.read<std::uint8_t>();
  request.value = reader.read<std::uint16_t>();
  request.index = reader.read<std::uint16_t>();
  request.length = reader.read<std::uint16_t>();
  return std::optional<SetupRequest>(request);
}

void RawGadget::answer(const SetupRequest& request, ByteView bytes) {
  const std::size_t length = std::min<std::size_t>(bytes.size(), request.length);
  // The host sees the end of a shorter answer by a packet that is not full.
  const bool needs_empty_packet = length < request.length && length % packet_of_endpoint_0 == 0;
  auto memory = transfer(0, needs_empty_packet ? USB_RAW_IO_FLAGS_ZERO : 0, length, bytes.first(length));
  static_cast<void>(ioctl(descriptor_, USB_RAW_IOCTL_EP0_WRITE, memory.data()));
}

void RawGadget::acknowledge(const SetupRequest& request) {
  auto memory = transfer(0, 0, request.length, {});
  static_cast<void>(ioctl(descriptor_, USB_RAW_IOCTL_EP0_READ, memory.data()));
}

void RawGadget::refuse() { static_cast<void>(ioctl(descriptor_, USB_RAW_IOCTL_EP0_STALL, 0)); }

Expected<int> RawGadget::enable(ByteView bytes) {
  usb_endpoint_descriptor descriptor{};
  std::memcpy(&descriptor, bytes.data(), std::min<std::size_t>(bytes.size(), USB_DT_ENDPOINT_SIZE));
  const int endpoint = ioctl(descriptor_, USB_RAW_IOCTL_EP_ENABLE, &descriptor);
  if (endpoint < 0) return refused("an endpoint cannot be had");
  return endpoint;
}

void RawGadget::set_configured() {
  static_cast<void>(ioctl(descriptor_, USB_RAW_IOCTL_VBUS_DRAW, 0x32));
  static_cast<void>(ioctl(descriptor_, USB_RAW_IOCTL_CONFIGURE, 0));
}

std::optional<std::size_t> RawGadget::write(int endpoint, ByteView bytes) {
  auto memory = transfer(endpoint, 0, bytes.size(), bytes);
  const int written = ioctl(descriptor_, USB_RAW_IOCTL_EP_WRITE, memory.data());
  if (written < 0) return std::nullopt;
  return static_cast<std::size_t>(written);
}

std::optional<std::vector<std::uint8_t>> RawGadget::read(int endpoint, std::size_t most) {
  auto memory = transfer(endpoint, 0, most, {});
  const int count = ioctl(descriptor_, USB_RAW_IOCTL_EP_READ, memory.data());
  if (count < 0) return std::nullopt;
  const auto first = memory.begin() + sizeof(usb_raw_ep_io);
  return std::vector<std::uint8_t>(first, first + count);
}

}  // namespace rigcal::hil
