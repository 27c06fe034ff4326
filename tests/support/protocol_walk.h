#pragma once

#include <vector>

#include "core/base/error.h"
#include "drivers/livox/protocol/host_protocol.h"

namespace rigcal::livox {

/// Drives a HostProtocol with two devices by a script of any bytes (datagrams, answers that fit, steps in time, wishes
/// of a user) and asserts after each step what must hold whatever happens.
class ProtocolWalk {
 public:
  static void run(ByteView script) {
    ProtocolWalk walk(script);
    while (walk.script_.left() > 0) walk.step();
    walk.end();
  }

 private:
  explicit ProtocolWalk(ByteView script) : script_(script), protocol_(make()) {}

  static HostProtocol make() {
    WantedDevice avia;
    avia.broadcast_code = "3JEDK380010Z391";
    avia.settings = {
        Coordinates::cartesian, Echoes::dual, ImuRate::hz_200, Switch::on, Switch::off, Switch::on, Switch::on,
        StoredExtrinsics{}};
    WantedDevice mid40;
    mid40.ip = Ipv4{192, 168, 1, 21};
    mid40.settings.fan = Switch::on;
    auto made = HostProtocol::create({{{192, 168, 1, 5}, {255, 255, 255, 0}, 55501, 56001, 56001}}, {avia, mid40});
    RIGCAL_ASSERT(made.has_value(), "no protocol");
    return *std::move(made);
  }

  void step() {
    out_.clear();
    const auto operation = script_.read<std::uint8_t>();
    const auto argument = script_.read<std::uint8_t>();
    const std::size_t device = argument & 1U;
    switch (operation % 9) {
      case 0:
        hear(device, script_.take(std::min<std::size_t>(script_.left(), argument)));
        break;
      case 1:
        now_ns_ += static_cast<std::int64_t>(argument) * argument * 1'000'000;
        protocol_.tick(now_ns_, out_);
        RIGCAL_ASSERT(!protocol_.deadline_ns() || *protocol_.deadline_ns() > now_ns_, "a deadline that stands still");
        break;
      case 2:
        hear(device, make_broadcast(broadcast(device), argument));
        break;
      case 3:
      case 4:
        answer(argument);
        break;
      case 5:
        request(device, argument);
        break;
      case 6:
        protocol_.set_sampling(now_ns_, device, (argument & 2U) != 0, out_);
        break;
      case 7:
        protocol_.set_power(now_ns_, device, static_cast<PowerMode>(1 + (argument >> 1U) % 3), out_);
        break;
      default:
        if (argument == 0xFF) protocol_.leave(now_ns_, out_);
        break;
    }
    check();
  }

  static Broadcast broadcast(std::size_t device) {
    if (device == 0) return {"3JEDK380010Z391", DeviceType::avia, 0};
    return {"0TFDG3B00600551", DeviceType::mid40, 0};
  }
  void hear(std::size_t device, ByteView bytes) {
    const Ipv4 ip = device == 0 ? Ipv4{192, 168, 1, 139} : Ipv4{192, 168, 1, 21};
    protocol_.receive(now_ns_, 0, {ip, kDevicePort}, bytes, out_);
  }
  // One of the latest requests, answered with bytes of the script.
  void answer(std::uint8_t argument) {
    if (sent_.empty()) return;
    const Asked& asked = sent_[argument % sent_.size()];
    const std::size_t size = command_of(asked.frame) == Command::heartbeat ? 7 : 1 + 4 * ((argument >> 4U) & 1U);
    const ByteView bytes = script_.take(std::min(script_.left(), size));
    std::vector<std::uint8_t> payload(bytes.begin(), bytes.end());
    if (argument < 128 && !payload.empty()) payload[0] = 0;
    payload.resize(size);
    protocol_.receive(now_ns_, 0, asked.to,
                      make_control_frame({FrameType::ack, asked.frame.seq, asked.frame.set, asked.frame.id, payload}),
                      out_);
  }
  void request(std::size_t device, std::uint8_t argument) {
    const ControlPayload requests[] = {
        GetIpModeRequest{}, RebootRequest{100}, SetUtcTimeRequest{},     DisconnectRequest{},
        SetFanRequest{},    HeartbeatRequest{}, ReadExtrinsicsRequest{}, ReadParametersRequest{{1, 2}}};
    static_cast<void>(protocol_.request(now_ns_, device, requests[(argument >> 1U) % 8], out_));
  }

  void check() {
    RIGCAL_ASSERT(out_.frames.size() <= 4 * protocol_.device_count(), "too many frames at once");
    RIGCAL_ASSERT(out_.events.size() <= 40 * protocol_.device_count(), "too many events at once");
    RIGCAL_ASSERT(protocol_.sightings().size() <= kMaxSightings, "too many sightings");
    for (const OutgoingFrame& outgoing : out_.frames) {
      const auto frame = parse_control_frame(outgoing.bytes);
      RIGCAL_ASSERT(frame.has_value() && decode_control(*frame).has_value(), "a frame that nobody understands");
      RIGCAL_ASSERT(outgoing.host == 0, "a frame from nowhere");
      RIGCAL_ASSERT(outgoing.to.ip == (Ipv4{192, 168, 1, 139}) || outgoing.to.ip == (Ipv4{192, 168, 1, 21}),
                    "a frame to a stranger");
      if (sent_.size() == 8) sent_.erase(sent_.begin());
      ControlFrame kept = *frame;
      kept.payload = {};
      sent_.push_back({kept, outgoing.to});
    }
    for (const Event& event : out_.events) RIGCAL_ASSERT(!event_text(event.content).empty(), "an event without words");
    for (std::size_t i = 0; i < protocol_.device_count(); ++i) {
      RIGCAL_ASSERT(protocol_.device(i).state <= LinkState::closed, "no state");
      const bool closed = protocol_.device(i).state == LinkState::closed;
      RIGCAL_ASSERT(closed || !closed_[i], "a closed link that opened again");
      closed_[i] = closed;
    }
  }
  // Whatever was before: all devices are free a second after leaving.
  void end() {
    out_.clear();
    protocol_.leave(now_ns_, out_);
    for (int i = 0; i <= 20; ++i) {
      protocol_.tick(now_ns_, out_);
      now_ns_ += kLeaveNs / 20;
    }
    RIGCAL_ASSERT(protocol_.is_closed() && !protocol_.deadline_ns(), "not closed");
  }

  struct Asked {
    ControlFrame frame;
    Endpoint to;
  };

  ByteReader script_;
  HostProtocol protocol_;
  ProtocolOutput out_;
  std::int64_t now_ns_ = 1'000'000'000;
  std::vector<Asked> sent_;
  bool closed_[2] = {false, false};
};

}  // namespace rigcal::livox
