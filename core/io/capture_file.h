#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/io/input_file.h"

namespace rigcal {

/// One frame as it stands in a capture file.
struct CapturedFrame {
  std::optional<std::int64_t> stamp_ns;  ///< Since 1970; nothing where the file has no stamp, or a senseless one.
  std::uint32_t link_type = 0;           ///< LINKTYPE_ number: what the bytes begin with.
  std::uint32_t wire_bytes = 0;          ///< Length on the wire; more than `bytes` where it was cut when recording.
  bool broken = false;                   ///< Its record contradicts itself, so there are no bytes.
  ByteView bytes;                        ///< Live until the next frame is asked for.
};

/// The frames of a pcap file (micro- and nanosecond stamps, both byte orders) or a pcapng file (sections of both byte
/// orders, any number of interfaces, each with its own link type, time resolution and time offset), in their order.
/// Formats: draft-ietf-opsawg-pcap and draft-ietf-opsawg-pcapng.
class CaptureFile {
 public:
  /// Errors: missing, no permission, empty, compressed, no capture file.
  [[nodiscard]] static Expected<CaptureFile> open(const std::string& path, AwaitGrowth await_growth = {});

  /// False at the end; the end was a proper one where `failure` and `damage` are empty then.
  [[nodiscard]] bool next(CapturedFrame& frame);
  /// Why reading ended before the file did, one clause with the offset in the file.
  [[nodiscard]] const std::string& damage() const { return damage_; }
  /// What went wrong when reading ("Input/output error"): then what was read is not all that the file holds.
  [[nodiscard]] const std::string& failure() const { return file_.failure(); }
  /// Where the last whole block or frame ends: so much of a damaged file is worth keeping.
  [[nodiscard]] std::uint64_t whole_bytes() const { return whole_bytes_; }

 private:
  struct Interface {
    std::uint32_t link_type = 0;
    std::uint8_t resolution = 6;  ///< if_tsresol: a power of ten, or of two with the top bit.
    std::int64_t offset_s = 0;    ///< if_tsoffset.
  };

  explicit CaptureFile(InputFile file) : file_(std::move(file)) {}
  Expected<void> read_head();
  bool next_record(CapturedFrame& frame);
  bool next_packet_block(CapturedFrame& frame);
  bool begin_section();
  bool add_interface(ByteView body);
  void read_packet(std::uint32_t type, ByteView body, CapturedFrame& frame) const;
  bool damaged(std::uint64_t offset, const std::string& what);
  [[nodiscard]] std::uint16_t u16(ByteView bytes, std::size_t at) const;
  [[nodiscard]] std::uint32_t u32(ByteView bytes, std::size_t at) const;
  [[nodiscard]] static std::optional<std::int64_t> stamp_ns(const Interface& interface, std::uint64_t ticks);

  InputFile file_;
  bool blocks_ = false;                ///< pcapng.
  bool swapped_ = false;               ///< Of the other byte order than this machine.
  std::vector<Interface> interfaces_;  ///< Of this section; the only one of a pcap file.
  std::string damage_;
  std::uint64_t whole_bytes_ = 0;
};

}  // namespace rigcal
