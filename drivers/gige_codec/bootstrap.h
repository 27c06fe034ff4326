#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/gige_codec/command.h"

namespace rigcal::gige {

/// Addresses of the registers that every device has ("bootstrap registers").
namespace bootstrap {
constexpr std::uint32_t kVersion = 0x0000;
constexpr std::uint32_t kIpConfiguration = 0x0014;
constexpr std::uint32_t kIp = 0x0024;
constexpr std::uint32_t kMask = 0x0034;
constexpr std::uint32_t kGateway = 0x0044;
constexpr std::uint32_t kUserName = 0x00E8;
constexpr std::uint32_t kFirstUrl = 0x0200;
constexpr std::uint32_t kSecondUrl = 0x0400;
constexpr std::size_t kUrlBytes = 512;
constexpr std::uint32_t kInterfaces = 0x0600;
constexpr std::uint32_t kPersistentIp = 0x064C;
constexpr std::uint32_t kPersistentMask = 0x065C;
constexpr std::uint32_t kPersistentGateway = 0x066C;
constexpr std::uint32_t kLinkSpeed = 0x0670;
constexpr std::uint32_t kMessageChannels = 0x0900;
constexpr std::uint32_t kStreamChannels = 0x0904;
constexpr std::uint32_t kStreamCapability = 0x0930;
constexpr std::uint32_t kControlCapability = 0x0934;
constexpr std::uint32_t kHeartbeatTimeout = 0x0938;
constexpr std::uint32_t kTickFrequencyHigh = 0x093C;
constexpr std::uint32_t kTickFrequencyLow = 0x0940;
constexpr std::uint32_t kTimestampControl = 0x0944;
constexpr std::uint32_t kTimestampHigh = 0x0948;
constexpr std::uint32_t kTimestampLow = 0x094C;
constexpr std::uint32_t kDiscoveryDelay = 0x0950;
constexpr std::uint32_t kControlConfiguration = 0x0954;
constexpr std::uint32_t kPendingTimeout = 0x0958;
constexpr std::uint32_t kPrivilege = 0x0A00;
constexpr std::uint32_t kPrimaryPort = 0x0A04;
constexpr std::uint32_t kPrimaryIp = 0x0A14;
constexpr std::uint32_t kStreamPort = 0x0D00;
constexpr std::uint32_t kStreamPacketSize = 0x0D04;
constexpr std::uint32_t kStreamPacketDelay = 0x0D08;
constexpr std::uint32_t kStreamDestination = 0x0D18;
constexpr std::uint32_t kStreamSourcePort = 0x0D1C;
constexpr std::uint32_t kStreamChannelCapability = 0x0D20;
}  // namespace bootstrap

/// Bits of the privilege register.
constexpr std::uint32_t kExclusive = 1U << 0U;
constexpr std::uint32_t kControl = 1U << 1U;
/// Bits of the stream's packet size register.
constexpr std::uint32_t kFireTestPacket = 1U << 31U;
constexpr std::uint32_t kDoNotFragment = 1U << 30U;
constexpr std::uint32_t kPacketSizeBits = 0xFFFF;
/// Bits of the timestamp control register.
constexpr std::uint32_t kTimestampReset = 1U << 0U;
constexpr std::uint32_t kTimestampLatch = 1U << 1U;
/// Bits of the control configuration register.
constexpr std::uint32_t kHeartbeatOff = 1U << 0U;
constexpr std::uint32_t kExtendedStatus = 1U << 18U;
/// Bits of the control capability register.
constexpr std::uint32_t kCanConcatenate = 1U << 0U;
constexpr std::uint32_t kCanWriteMemory = 1U << 1U;
constexpr std::uint32_t kCanResend = 1U << 2U;
constexpr std::uint32_t kCanSayPending = 1U << 5U;
constexpr std::uint32_t kHasExtendedStatus = 1U << 18U;
constexpr std::uint32_t kTellsPrimary = 1U << 27U;
constexpr std::uint32_t kTellsLinkSpeed = 1U << 28U;
constexpr std::uint32_t kCanSwitchHeartbeatOff = 1U << 29U;
constexpr std::uint32_t kHasSerial = 1U << 30U;
constexpr std::uint32_t kHasUserName = 1U << 31U;
/// Bits of the IP configuration registers.
constexpr std::uint32_t kPersistent = 1U << 0U;
constexpr std::uint32_t kDhcp = 1U << 1U;
constexpr std::uint32_t kLinkLocal = 1U << 2U;

/// Who a device is: the start of its registers, and what it answers to a discovery.
struct DeviceIdentity {
  static constexpr std::size_t kBytes = 0xF8;

  std::uint16_t version_major = 1;
  std::uint16_t version_minor = 2;
  std::uint32_t device_mode = 0x8000'0001;  ///< Big-endian, a transmitter, texts in UTF-8.
  Mac mac{};
  std::uint32_t ip_options = kLinkLocal | kDhcp | kPersistent;
  std::uint32_t ip_configuration = kLinkLocal | kPersistent;
  Ipv4 ip{};
  Ipv4 mask{};
  Ipv4 gateway{};
  std::string manufacturer;    ///< At most 31 characters,
  std::string model;           ///< 31,
  std::string device_version;  ///< 31,
  std::string information;     ///< 47,
  std::string serial;          ///< 15,
  std::string user_name;       ///< 15.
  bool operator==(const DeviceIdentity&) const = default;
};

/// Reads the first `kBytes` of a payload or a memory. Texts end at their first NUL, or with their field.
[[nodiscard]] Expected<DeviceIdentity> decode_identity(ByteView bytes);
/// Texts that are too long are cut, so that a NUL ends them.
[[nodiscard]] std::vector<std::uint8_t> encode_identity(const DeviceIdentity& identity);

}  // namespace rigcal::gige
