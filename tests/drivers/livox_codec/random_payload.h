#pragma once

#include <array>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/random.h"
#include "drivers/livox_codec/control_payload.h"
#include "drivers/livox_codec/wire_fields.h"

namespace rigcal::livox {

/// Fills payloads with random values that may stand on the wire.
class RandomPayload {
 public:
  explicit RandomPayload(std::uint64_t seed) : random_(seed) {}

  /// Of any alternative of ControlPayload.
  template <class T>
  T make() {
    T payload{};
    fill(payload);
    return payload;
  }

 private:
  template <class T>
  void fill(T& value) {
    if constexpr (requires { value.fields(); }) {
      std::apply([&](auto&... field) { (fill(field), ...); }, value.fields());
    } else if constexpr (std::is_same_v<T, PowerMode>) {
      value = static_cast<T>(1 + random_.below(3));
    } else if constexpr (std::is_same_v<T, DeviceType>) {
      value = random_.below(2) == 0 ? DeviceType::avia : DeviceType::hub;
    } else if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(random_.below(2));
    } else if constexpr (std::is_floating_point_v<T>) {
      value = static_cast<T>(random_.uniform(-180.0, 180.0));
    } else {
      value = static_cast<T>(random_.next_u64());
    }
  }
  void fill(std::string& code) {
    code.resize(kBroadcastCodeLength);
    for (char& c : code) c = static_cast<char>(0x21 + random_.below(0x5E));
  }
  void fill(UtcTime& time) {
    constexpr std::int64_t utc_2000 = 946'684'800'000'000;  // Microseconds, as on the wire.
    time.unix_ns = (utc_2000 + static_cast<std::int64_t>(random_.below(2'000'000'000'000'000))) * 1000;
  }
  void fill(Parameter& parameter) {
    fill(parameter.key);
    parameter.value.resize(random_.below(9));
    for (std::uint8_t& byte : parameter.value) fill(byte);
  }
  template <class T, std::size_t size>
  void fill(std::array<T, size>& values) {
    for (T& value : values) fill(value);
  }
  template <class T>
  void fill(std::optional<T>& value) {
    if (random_.below(2) == 0) fill(value.emplace());
  }
  template <class T>
  void fill(std::vector<T>& items) {
    items.resize(1 + random_.below(27));  // Nine slots of a Hub with three LiDARs each.
    for (T& item : items) fill(item);
  }
  void fill(RawControl& raw) {
    raw = {static_cast<FrameType>(random_.below(3)),
           CommandSet::lidar,
           static_cast<std::uint8_t>(0x20 + random_.below(0x80)),
           {}};
    raw.payload.resize(random_.below(40));
    for (std::uint8_t& byte : raw.payload) fill(byte);
  }
  void fill(Broadcast& broadcast) {
    fill(broadcast.broadcast_code);
    fill(broadcast.type);
    fill(broadcast.command_port);
  }
  void fill(Handshake& handshake) {
    fill(handshake.host_ip);
    fill(handshake.data_port);
    fill(handshake.command_port);
    fill(handshake.imu_port);
  }
  void fill(ResetParametersRequest& reset) {
    fill(reset.scope);
    fill(reset.keys);
    if (random_.below(2) == 0) reset = ResetParametersRequest::all();
  }

  Random random_;
};

}  // namespace rigcal::livox
