#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/livox/protocol/host_protocol.h"

namespace rigcal::livox {

constexpr std::int64_t kMs = 1'000'000;

inline HostAddress lab_host() { return {{192, 168, 1, 5}, {255, 255, 255, 0}, 55501, 56001, 56001}; }

inline Broadcast avia_broadcast() { return {"3JEDK380010Z391", DeviceType::avia, 0}; }

inline WantedDevice wanted_avia() {
  WantedDevice wanted;
  wanted.broadcast_code = avia_broadcast().broadcast_code;
  wanted.settings.coordinates = Coordinates::cartesian;
  return wanted;
}

/// A host with one device that does what the test says; time stands still unless `pass` is called.
class Desk {
 public:
  explicit Desk(WantedDevice wanted = wanted_avia(), Broadcast says = avia_broadcast(),
                Endpoint at = {{192, 168, 1, 139}, kDevicePort})
      : device(at), broadcast(std::move(says)), protocol(make({std::move(wanted)})) {}

  [[nodiscard]] LinkState state() const { return protocol.device(0).state; }
  [[nodiscard]] const LinkInfo& info() const { return protocol.device(0); }

  void hear(ByteView bytes) { hear(device, bytes); }
  void hear(const Endpoint& from, ByteView bytes) { protocol.receive(now_ns, 0, from, bytes, out); }
  void hear_broadcast() { hear(make_broadcast(broadcast, ++broadcast_seq_)); }

  /// Steps of at most 50 ms, as a driver that oversleeps would take them.
  void pass(std::int64_t ms) {
    const std::int64_t end = now_ns + ms * kMs;
    while (now_ns < end) {
      now_ns = std::min(end, now_ns + 50 * kMs);
      protocol.tick(now_ns, out);
    }
  }
  /// The same with a device that answers heartbeats.
  void pass_alive(std::int64_t ms, WorkState work_state = WorkState::normal) {
    for (std::int64_t t = 0; t < ms; t += 100) {
      pass(100);
      beat(work_state);
    }
  }

  /// The last frame of this kind that was sent.
  [[nodiscard]] std::optional<ControlFrame> sent(Command command) const {
    for (auto it = out.frames.rbegin(); it != out.frames.rend(); ++it) {
      const auto frame = parse_control_frame(it->bytes);
      EXPECT_TRUE(frame.has_value());
      if (frame && command_of(*frame) == command) return *frame;
    }
    return std::nullopt;
  }
  [[nodiscard]] std::size_t count_sent(Command command) const {
    std::size_t count = 0;
    for (const OutgoingFrame& outgoing : out.frames) {
      const auto frame = parse_control_frame(outgoing.bytes);
      if (frame && command_of(*frame) == command) ++count;
    }
    return count;
  }
  /// The last frame that was sent and is no heartbeat.
  [[nodiscard]] std::optional<ControlFrame> asked() const {
    for (auto it = out.frames.rbegin(); it != out.frames.rend(); ++it) {
      const auto frame = parse_control_frame(it->bytes);
      if (frame && command_of(*frame) != Command::heartbeat) return *frame;
    }
    return std::nullopt;
  }

  /// Answers the last request of the payload's command.
  void answer(const ControlPayload& payload, int seq_error = 0) {
    const auto request = sent(command_of_payload(payload));
    ASSERT_TRUE(request.has_value());
    hear(encode_control(payload, static_cast<std::uint16_t>(request->seq + seq_error)));
  }
  void beat(WorkState work_state = WorkState::normal, std::uint32_t status = 0, ReturnCode ret = ReturnCode::success) {
    if (const auto heartbeat = sent(Command::heartbeat)) beaten_ = heartbeat->seq;
    if (sent(Command::heartbeat)) answer(HeartbeatAck{ret, work_state, 0, status});
  }

  /// Until there is a heartbeat that was not answered yet.
  void pass_to_next_heartbeat() {
    for (int i = 0; i < 20 && sent(Command::heartbeat) && sent(Command::heartbeat)->seq == beaten_; ++i) pass(50);
  }

  template <class T>
  [[nodiscard]] std::vector<T> told() const {
    std::vector<T> found;
    for (const Event& event : out.events)
      if (const auto* content = std::get_if<T>(&event.content)) found.push_back(*content);
    return found;
  }
  [[nodiscard]] std::optional<Outcome> outcome(Command command) const {
    std::optional<Outcome> last;
    for (const RequestEnded& ended : told<RequestEnded>())
      if (ended.command == command) last = ended.outcome;
    return last;
  }

  /// Up to the state where the device samples.
  void shake_hands() {
    hear_broadcast();
    answer(HandshakeAck{});
  }
  void identify(FirmwareVersion firmware = {11, 9, 0, 0}) {
    shake_hands();
    answer(DeviceInformationAck{ReturnCode::success, firmware});
  }
  void sample() {
    identify();
    beat();
    answer(CoordinatesAck{});
    answer(SamplingAck{});
    ASSERT_EQ(state(), LinkState::sampling);
  }

  std::int64_t now_ns = 1'000'000 * kMs;
  Endpoint device;
  Broadcast broadcast;
  ProtocolOutput out;
  HostProtocol protocol;

 private:
  static HostProtocol make(std::vector<WantedDevice> wanted) {
    auto made = HostProtocol::create({lab_host()}, std::move(wanted));
    EXPECT_TRUE(made.has_value());
    return *std::move(made);
  }
  static Command command_of_payload(const ControlPayload& payload) {
    return command_of(*parse_control_frame(encode_control(payload, 1)));
  }

  std::uint16_t broadcast_seq_ = 0;
  std::optional<std::uint16_t> beaten_;
};

}  // namespace rigcal::livox
