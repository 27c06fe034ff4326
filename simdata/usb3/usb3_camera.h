#pragma once

#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "simdata/gige/virtual_camera.h"
#include "simdata/usb3/control_packet.h"

namespace rigcal::sim::usb3 {

/// Where the tables of a device lie in its memory, and what is in them (USB3 Vision 1.0, GenCP 1.1). The first table is
/// at 0; its names are in simdata/gige/camera_description.h.
namespace table {
inline constexpr std::uint32_t kGencpVersion = 0x000;
inline constexpr std::uint32_t kCapability = 0x1C4;
inline constexpr std::uint32_t kResponseTime = 0x1CC;
inline constexpr std::uint32_t kManifestAddress = 0x1D0;
inline constexpr std::uint32_t kSecondAddress = 0x1D8;
inline constexpr std::uint32_t kTimestamp = 0x1F0;
inline constexpr std::uint32_t kTimestampLatch = 0x1F8;
inline constexpr std::uint32_t kTimestampIncrement = 0x1FC;
inline constexpr std::uint32_t kManifest = 0x400;
inline constexpr std::uint32_t kSecond = 0x500;
inline constexpr std::uint32_t kMaxCommand = kSecond + 0x14;
inline constexpr std::uint32_t kMaxAnswer = kSecond + 0x18;
inline constexpr std::uint32_t kStreams = kSecond + 0x1C;
inline constexpr std::uint32_t kStreamAddress = kSecond + 0x20;
inline constexpr std::uint32_t kStreamLength = kSecond + 0x28;
inline constexpr std::uint32_t kSpeed = kSecond + 0x40;
inline constexpr std::uint32_t kStream = 0x600;
inline constexpr std::uint32_t kStreamControl = kStream + 0x04;  ///< Bit 0: frames may be sent.
inline constexpr std::uint32_t kPayloadBytes = kStream + 0x08;
inline constexpr std::uint32_t kLeaderBytesNeeded = kStream + 0x10;
inline constexpr std::uint32_t kTrailerBytesNeeded = kStream + 0x14;
inline constexpr std::uint32_t kMaxLeader = kStream + 0x18;  ///< From here to kEnd the host says how it reads.
inline constexpr std::uint32_t kEnd = kStream + 0x30;
}  // namespace table

/// A USB3 Vision camera as its firmware behaves: the virtual camera of GigE Vision with its features, exposures and
/// triggers, behind the tables and packets of the other standard. A pure state machine: packets, pulses and time in;
/// answers and exposed frames out. It has no chunks.
class Usb3Camera {
 public:
  Usb3Camera(VirtualCameraOptions options, std::int64_t now_ns);

  /// A packet on the control endpoint, whatever is in it; the answer, or nothing where none is due.
  [[nodiscard]] std::vector<std::uint8_t> receive(std::int64_t now_ns, ByteView packet);
  /// The frames that were exposed meanwhile and may be sent.
  void tick(std::int64_t now_ns, std::vector<FrameOrder>& frames);
  /// When `tick` has something to do next.
  [[nodiscard]] std::int64_t deadline_ns() const { return camera_.deadline_ns(); }
  void pulse(const LinePulse& pulse) { camera_.pulse(pulse); }
  /// The host has gone: nothing is exposed or sent any more.
  void detach(std::int64_t now_ns);

  [[nodiscard]] bool may_send() const { return may_send_; }
  /// What its clock has read at a frame.
  [[nodiscard]] static std::uint64_t stamp_ns(const FrameOrder& frame) {
    return frame.ticks * (1'000'000'000U / CameraRegisters::kTicksPerSecond);
  }

 private:
  void define_tables(const VirtualCameraOptions& options);
  void take_control(std::int64_t now_ns);
  /// A value of the tables, which are in little-endian order.
  template <class T>
  void set(std::uint32_t address, T value);
  [[nodiscard]] std::vector<std::uint8_t> ask(std::int64_t now_ns, const gige::Request& request, gige::Status& status);
  [[nodiscard]] gige::Status read(std::int64_t now_ns, std::uint64_t address, std::size_t count,
                                  std::vector<std::uint8_t>& bytes);
  [[nodiscard]] gige::Status write(std::int64_t now_ns, std::uint64_t address, ByteView bytes);
  [[nodiscard]] gige::Status write_table(std::int64_t now_ns, std::uint32_t address, ByteView bytes);
  [[nodiscard]] gige::Status write_feature(std::int64_t now_ns, std::uint32_t address, ByteView bytes);

  VirtualCamera camera_;
  std::vector<std::uint8_t> tables_;
  std::vector<FrameOrder> exposed_;  ///< While a command was served.
  std::uint16_t id_ = 1;
  bool may_send_ = false;
};

}  // namespace rigcal::sim::usb3
