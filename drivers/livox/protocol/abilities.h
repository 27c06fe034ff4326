#pragma once

#include <string>

#include "drivers/livox_codec/control_payload.h"

/// What models and firmwares can do. By the vendor's tables, which know no firmware newer than themselves: newer ones
/// can what older ones could.
namespace rigcal::livox {

/// What a request is, ack or message of `payload` belongs to; for a RawControl by its numbers.
[[nodiscard]] Command command_of(const ControlPayload& payload);

/// Whether a device can be expected to do this. A device that is asked all the same refuses (or stays silent).
[[nodiscard]] bool can_do(DeviceType type, const FirmwareVersion& firmware, const ControlPayload& request);

/// Whether the request can be put on the wire: dates from 2000 to 2255, lists and parameters that fit into a frame.
[[nodiscard]] bool can_send(const ControlPayload& request);

/// "11.09.00.00".
[[nodiscard]] std::string firmware_text(const FirmwareVersion& firmware);

}  // namespace rigcal::livox
