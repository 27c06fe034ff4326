#pragma once

#include <concepts>
#include <cstdint>
#include <utility>
#include <variant>
#include <vector>

#include "drivers/livox_codec/discovery.h"
#include "drivers/livox_codec/general_commands.h"
#include "drivers/livox_codec/hub_commands.h"
#include "drivers/livox_codec/lidar_commands.h"

namespace rigcal::livox {

/// A frame that is none of the payloads below, as it came.
struct RawControl {
  FrameType type = FrameType::command;
  CommandSet set = CommandSet::general;
  std::uint8_t id = 0;
  std::vector<std::uint8_t> payload;
  bool operator==(const RawControl&) const = default;
};

/// Every request, ack and message of the protocol.
using ControlContent = std::variant<
    RawControl, Broadcast, Handshake, HandshakeAck, DeviceInformationRequest, DeviceInformationAck, HeartbeatRequest,
    HeartbeatAck, SamplingRequest, SamplingAck, CoordinatesRequest, CoordinatesAck, DisconnectRequest, DisconnectAck,
    AbnormalStatus, SetIpModeRequest, SetIpModeAck, GetIpModeRequest, GetIpModeAck, RebootRequest, RebootAck,
    WriteParametersRequest, WriteParametersAck, ReadParametersRequest, ReadParametersAck, ResetParametersRequest,
    ResetParametersAck, SetPowerModeRequest, SetPowerModeAck, WriteExtrinsicsRequest, WriteExtrinsicsAck,
    ReadExtrinsicsRequest, ReadExtrinsicsAck, RainSuppressionRequest, RainSuppressionAck, SetFanRequest, SetFanAck,
    GetFanRequest, GetFanAck, SetReturnModeRequest, SetReturnModeAck, GetReturnModeRequest, GetReturnModeAck,
    SetImuRateRequest, SetImuRateAck, GetImuRateRequest, GetImuRateAck, SetUtcTimeRequest, SetUtcTimeAck,
    HubListLidarsRequest, HubListLidarsAck, HubSetPowerModeRequest, HubSetPowerModeAck, HubSlotPowerRequest,
    HubSlotPowerAck, HubWriteExtrinsicsRequest, HubWriteExtrinsicsAck, HubReadExtrinsicsRequest, HubReadExtrinsicsAck,
    HubLidarStatusRequest, HubLidarStatusAck, HubUseExtrinsicsRequest, HubUseExtrinsicsAck, HubRainSuppressionRequest,
    HubRainSuppressionAck, HubSlotPowerStatusRequest, HubSlotPowerStatusAck, HubSetFanRequest, HubSetFanAck,
    HubGetFanRequest, HubGetFanAck, HubSetReturnModeRequest, HubSetReturnModeAck, HubGetReturnModeRequest,
    HubGetReturnModeAck, HubSetImuRateRequest, HubSetImuRateAck, HubGetImuRateRequest, HubGetImuRateAck>;

template <class T, class Variant>
constexpr bool is_alternative_of = false;
template <class T, class... Alternative>
constexpr bool is_alternative_of<T, std::variant<Alternative...>> = (std::same_as<T, Alternative> || ...);

/// What a control frame says, whoever sent it. It is its content; that it can be copied is said here and done in one
/// place, as the compiler takes seconds for what a variant of so many does.
struct ControlPayload final : ControlContent {
  ControlPayload() noexcept;  ///< A RawControl without payload.
  template <class T>
  requires is_alternative_of<T, ControlContent> ControlPayload(T content)
      : ControlContent(std::in_place_type<T>, std::move(content)) {}
  ControlPayload(const ControlPayload& other);
  ControlPayload(ControlPayload&& other) noexcept;
  ControlPayload& operator=(ControlPayload other) noexcept;
  ~ControlPayload();
};

/// Reads the payload of a frame; a frame that the protocol does not know becomes a RawControl.
///
/// Errors name the frame and the offset in its payload: too short or too long, a list that does not fit, a code that is
/// not text, a number that is not finite, a date that is none; in requests also a value that its enumeration does not
/// have. In acks such values are kept, as a host has to live with devices that know more than it does. An ack of a
/// single byte that says failure is taken for every command: nothing but `ret` counts in it.
[[nodiscard]] Expected<ControlPayload> decode_control(const ControlFrame& frame);

/// The bytes of the frame that says this; an ack takes the `seq` of its request. A Handshake goes out as a command (see
/// `make_handshake` for the other way). The frame must not get longer than `kMaxFrameBytes`; lists have at most 255
/// entries, codes 15 characters.
[[nodiscard]] std::vector<std::uint8_t> encode_control(const ControlPayload& payload, std::uint16_t seq);

/// The ack of one byte with which a device refuses any request, also one that it does not know or cannot read.
[[nodiscard]] std::vector<std::uint8_t> make_refusal(const ControlFrame& request);

}  // namespace rigcal::livox
