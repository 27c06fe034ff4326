#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <optional>
#include <vector>

#include "simdata/gige/virtual_camera.h"

namespace rigcal::sim {

constexpr std::int64_t second_ns = 1'000'000'000;

inline VirtualCameraOptions desk_camera() {
  VirtualCameraOptions options;
  options.identity.mac = {0x34, 0xBD, 0x20, 1, 2, 3};
  options.identity.ip = {192, 168, 1, 31};
  options.identity.manufacturer = "Hikrobot";
  options.identity.model = "MV-CA013-21UC";
  options.identity.serial = "00F12345678";
  options.pixel_formats = {"BayerRG8", "BayerRG12", "Mono8"};
  return options;
}

/// A virtual camera on a desk: commands go in as bytes, answers come out decoded.
class CameraDesk {
 public:
  explicit CameraDesk(const VirtualCameraOptions& options = desk_camera()) : camera(options, 50123, now_ns) {}

  const Endpoint host{{192, 168, 1, 5}, 40001};
  const Endpoint stranger{{192, 168, 1, 6}, 40001};
  std::int64_t now_ns = 1000 * second_ns;
  CameraOutput out;
  VirtualCamera camera;

  /// Status and payload of the answer, or nothing where there is none.
  struct Reply {
    gige::Status status{};
    std::uint16_t id = 0;
    std::optional<gige::Ack> ack;
  };
  std::optional<Reply> ask(const Endpoint& from, const gige::Request& request) {
    return say(from, gige::encode_request(request, ++id_));
  }
  std::optional<Reply> say(const Endpoint& from, const std::vector<std::uint8_t>& bytes) {
    out.clear();
    camera.receive(now_ns, from, bytes, out);
    return last_reply();
  }
  /// The latest of the answers in `out`.
  [[nodiscard]] std::optional<Reply> last_reply() const {
    if (out.answers.empty()) return std::nullopt;
    const auto frame = gige::parse_ack(out.answers.back().bytes);
    EXPECT_TRUE(frame.has_value());
    Reply reply{frame->status, frame->id, std::nullopt};
    if (const auto ack = gige::decode_ack(*frame)) reply.ack = *ack;
    return reply;
  }

  gige::Status write(const Endpoint& from, std::uint32_t address, std::uint32_t value) {
    return ask(from, gige::WriteRegistersRequest{{{address, value}}})->status;
  }
  gige::Status write(Feature feature, std::uint32_t value, std::uint32_t index = 0) {
    return write(host, address_of(feature, index), value);
  }
  gige::Status write_real(Feature feature, float value) {
    return write(host, address_of(feature), std::bit_cast<std::uint32_t>(value));
  }
  std::uint32_t read(std::uint32_t address) {
    const auto reply = ask(host, gige::ReadRegistersRequest{{address}});
    EXPECT_EQ(reply->status, gige::Status::success) << std::hex << address;
    const auto* values = std::get_if<gige::ReadRegistersAck>(&*reply->ack);
    return values == nullptr || values->values.empty() ? 0 : values->values[0];
  }
  std::uint32_t read(Feature feature, std::uint32_t index = 0) { return read(address_of(feature, index)); }
  float read_real(Feature feature) { return std::bit_cast<float>(read(feature)); }

  void take_control(std::uint32_t privilege = gige::kControl) {
    EXPECT_EQ(write(host, gige::bootstrap::kPrivilege, privilege), gige::Status::success);
  }
  void open_stream() {
    EXPECT_EQ(write(host, gige::bootstrap::kStreamDestination, 0xC0A80105), gige::Status::success);
    EXPECT_EQ(write(host, gige::bootstrap::kStreamPort, 50500), gige::Status::success);
  }
  /// Lets time go by and the host keep its heartbeat; the frames that were exposed meanwhile.
  std::vector<FrameOrder> wait(std::int64_t time_ns) {
    std::vector<FrameOrder> frames;
    const std::int64_t end = now_ns + time_ns;
    while (now_ns < end) {
      now_ns = std::min(end, now_ns + second_ns / 1000);
      if (now_ns % second_ns < second_ns / 1000 && camera.owner()) static_cast<void>(read(gige::bootstrap::kPrivilege));
      frames.insert(frames.end(), out.frames.begin(), out.frames.end());
      out.clear();
      camera.tick(now_ns, out);
      frames.insert(frames.end(), out.frames.begin(), out.frames.end());
      out.frames.clear();
    }
    return frames;
  }

 private:
  std::uint16_t id_ = 0;
};

}  // namespace rigcal::sim
