#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "drivers/gige_codec/stream_packet.h"
#include "simdata/gige/virtual_camera.h"

namespace rigcal::sim {

/// A frame with its pixels, cut into packets when they are asked for.
class StreamBlock {
 public:
  /// `image` holds exactly `order.settings.image_bytes`; chunks are appended to it. `packet_bytes` with IP and UDP.
  StreamBlock(const FrameOrder& order, std::vector<std::uint8_t> image, std::uint32_t packet_bytes);

  [[nodiscard]] std::uint16_t id() const { return id_; }
  /// Leader and trailer are two of them.
  [[nodiscard]] std::uint32_t packet_count() const { return packets_; }
  [[nodiscard]] std::size_t memory_bytes() const { return payload_.size(); }

  /// A packet's two parts, to be sent behind one another.
  struct Packet {
    std::array<std::uint8_t, gige::kStreamHeaderBytes> header{};
    ByteView payload;  ///< Lives as long as the block.
  };
  /// `number` counts from 0 and must be one of the block's.
  [[nodiscard]] Packet packet(std::uint32_t number, gige::Status status) const;

  /// The block's memory for another one; nothing else may be asked afterwards.
  [[nodiscard]] std::vector<std::uint8_t> take_memory() { return std::move(payload_); }

 private:
  std::uint16_t id_;
  std::size_t room_;  ///< Payload bytes of a packet.
  std::uint32_t packets_;
  std::vector<std::uint8_t> leader_;
  std::vector<std::uint8_t> payload_;
  std::vector<std::uint8_t> trailer_;
};

}  // namespace rigcal::sim
