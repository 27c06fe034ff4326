#include "core/io/capture_file.h"

#include <array>
#include <utility>

#include "core/base/seconds.h"
#include "core/io/foreign_file.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

constexpr std::uint32_t pcap_micro = 0xA1B2C3D4;
constexpr std::uint32_t pcap_nano = 0xA1B23C4D;
constexpr std::uint32_t byte_order_magic = 0x1A2B3C4D;
constexpr std::size_t pcap_head_bytes = 24;
constexpr std::size_t record_head_bytes = 16;

// Block types of pcapng.
constexpr std::uint32_t section_header = 0x0A0D0D0A;
constexpr std::uint32_t interface_description = 1;
constexpr std::uint32_t old_packet = 2;
constexpr std::uint32_t simple_packet = 3;
constexpr std::uint32_t enhanced_packet = 6;

/// The largest snapshot length that capturing programs use.
constexpr std::size_t max_frame_bytes = 262'144;
/// Of a block that is read; others are skipped whatever their length.
constexpr std::size_t max_block_bytes = max_frame_bytes + 65'536;
constexpr std::size_t max_interfaces = 4096;
constexpr const char* mend_of_pipe = "save it to a file first";
/// Seconds that fit into int64 nanoseconds.
constexpr std::int64_t max_seconds = 9'223'372'035;

std::uint32_t swap_32(std::uint32_t value) { return __builtin_bswap32(value); }

std::uint64_t power_of_ten(unsigned exponent) {
  std::uint64_t value = 1;
  for (unsigned i = 0; i < exponent; ++i) value *= 10;
  return value;
}

template <class T>
T load(ByteView bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

/// Which program unpacks a file that begins like this, or null.
const char* packer_of(std::uint32_t magic) {
  if ((magic & 0xFFFF) == 0x8B1F) return "gunzip";
  if (magic == 0xFD2FB528) return "unzstd";
  if (magic == 0x587A37FD) return "unxz";
  return nullptr;
}

}  // namespace

std::uint16_t CaptureFile::u16(ByteView bytes, std::size_t at) const {
  const auto value = load<std::uint16_t>(bytes, at);
  return swapped_ ? __builtin_bswap16(value) : value;
}

std::uint32_t CaptureFile::u32(ByteView bytes, std::size_t at) const {
  const auto value = load<std::uint32_t>(bytes, at);
  return swapped_ ? swap_32(value) : value;
}

bool CaptureFile::damaged(std::uint64_t offset, const std::string& what) {
  damage_ = "at byte " + std::to_string(offset) + " " + what;
  return false;
}

Expected<CaptureFile> CaptureFile::open(const std::string& path, AwaitGrowth await_growth) {
  Expected<InputFile> file = InputFile::open(path, std::move(await_growth));
  if (!file) return file.error();
  CaptureFile capture(std::move(*file));
  if (const Expected<void> head = capture.read_head(); !head) return head.error();
  return capture;
}

Expected<void> CaptureFile::read_head() {
  const std::string path = file_.path();
  const ByteView first = file_.peek(4);
  if (!file_.failure().empty()) return read_failure(path, file_.failure());
  const bool is_pipe = !file_.size();
  if (first.empty() && is_pipe)
    return input_error("is a pipe that gives nothing, or has given already what is needed again", path, mend_of_pipe);
  if (first.empty()) return input_error("is empty", path, "give a packet dump (pcap or pcapng)");
  const bool cut = first.size() < 4;
  const std::uint32_t magic = cut ? 0 : load<std::uint32_t>(first, 0);
  blocks_ = magic == section_header;
  if (blocks_) return {};
  if (const char* packer = packer_of(magic)) {
    return input_error("is compressed", path, std::string("unpack it first (") + packer + ")");
  }
  swapped_ = swap_32(magic) == pcap_micro || swap_32(magic) == pcap_nano;
  const std::uint32_t native = swapped_ ? swap_32(magic) : magic;
  if (!cut && native != pcap_micro && native != pcap_nano) {
    if (auto foreign = foreign_file_error(file_.peek(foreign_file_bytes), path)) return *std::move(foreign);
    if (is_pipe) return input_error("is no packet dump, and a pipe can give nothing else", path, mend_of_pipe);
    return input_error("is no packet dump that can be read", path, "give a pcap or pcapng file");
  }
  const ByteView head = file_.take(pcap_head_bytes);
  if (head.size() < pcap_head_bytes) {
    if (!file_.failure().empty()) return read_failure(path, file_.failure());
    return input_error("ends within the header of the capture file", path, "record it again");
  }
  Interface interface;
  interface.link_type = u32(head, 20) & 0x03FF'FFFF;  // above that: the length of a frame check sequence
  interface.resolution = native == pcap_nano ? 9 : 6;
  interfaces_.push_back(interface);
  whole_bytes_ = pcap_head_bytes;
  return {};
}

bool CaptureFile::next(CapturedFrame& frame) {
  if (!damage_.empty()) return false;
  return blocks_ ? next_packet_block(frame) : next_record(frame);
}

bool CaptureFile::next_record(CapturedFrame& frame) {
  const std::uint64_t offset = file_.offset();
  const ByteView head = file_.take(record_head_bytes);
  if (head.empty() && file_.failure().empty()) return false;
  if (head.size() < record_head_bytes) return damaged(offset, "the header of a frame is cut");
  const std::uint64_t seconds = u32(head, 0);
  const std::uint64_t fraction = u32(head, 4);
  const std::size_t size = u32(head, 8);
  frame.wire_bytes = u32(head, 12);
  if (size > max_frame_bytes) return damaged(offset, "a frame claims " + std::to_string(size) + " bytes");
  const std::uint64_t ticks_per_s = interfaces_[0].resolution == 9 ? ns_per_second : 1'000'000;
  frame.link_type = interfaces_[0].link_type;
  frame.stamp_ns.reset();
  if (fraction < ticks_per_s) frame.stamp_ns = stamp_ns(interfaces_[0], seconds * ticks_per_s + fraction);
  frame.broken = false;
  frame.bytes = file_.take(size);
  if (frame.bytes.size() != size) return damaged(offset, "a frame is cut");
  whole_bytes_ = file_.offset();
  return true;
}

bool CaptureFile::begin_section() {
  const std::uint64_t offset = file_.offset();
  const ByteView head = file_.peek(16);
  if (head.size() < 16) return damaged(offset, "a section header is cut");
  const auto magic = load<std::uint32_t>(head, 8);
  if (magic != byte_order_magic && swap_32(magic) != byte_order_magic) {
    return damaged(offset, "a section header is no such");
  }
  swapped_ = magic != byte_order_magic;
  if (u16(head, 12) != 1) return damaged(offset, "a section has the unknown version " + std::to_string(u16(head, 12)));
  interfaces_.clear();
  return true;
}

bool CaptureFile::next_packet_block(CapturedFrame& frame) {
  while (true) {
    const std::uint64_t offset = file_.offset();
    const ByteView start = file_.peek(8);
    if (start.empty() && file_.failure().empty()) return false;
    if (start.size() < 8) return damaged(offset, "the header of a block is cut");
    if (load<std::uint32_t>(start, 0) == section_header && !begin_section()) return false;
    const ByteView head = file_.take(8);
    const std::uint32_t type = u32(head, 0);
    const std::size_t size = u32(head, 4);
    if (size < 12 || size % 4 != 0) return damaged(offset, "a block has the length " + std::to_string(size));
    const bool packet = type == enhanced_packet || type == old_packet || type == simple_packet;
    if (!packet && type != interface_description) {
      if (!file_.skip(size - 12)) return damaged(offset, "a block is cut");
    } else if (size > max_block_bytes) {
      return damaged(offset, "a block claims " + std::to_string(size) + " bytes");
    }
    const std::size_t body_bytes = packet || type == interface_description ? size - 12 : 0;
    const ByteView rest = file_.take(body_bytes + 4);
    if (rest.size() < body_bytes + 4) return damaged(offset, "a block is cut");
    if (u32(rest, body_bytes) != size) return damaged(offset, "a block tells two lengths of itself");
    const ByteView body = rest.first(body_bytes);
    if (type == interface_description && !add_interface(body)) return damaged(offset, "an interface is no such");
    whole_bytes_ = file_.offset();
    if (!packet) continue;
    read_packet(type, body, frame);
    return true;
  }
}

bool CaptureFile::add_interface(ByteView body) {
  if (body.size() < 8 || interfaces_.size() >= max_interfaces) return false;
  Interface interface;
  interface.link_type = u16(body, 0);
  for (std::size_t at = 8; at + 4 <= body.size();) {
    const std::uint16_t code = u16(body, at);
    const std::size_t size = u16(body, at + 2);
    if (code == 0 || size > body.size() - at - 4) break;
    if (code == 9 && size == 1) interface.resolution = body[at + 4];
    if (code == 14 && size == 8) {
      const auto value = load<std::uint64_t>(body, at + 4);
      interface.offset_s = static_cast<std::int64_t>(swapped_ ? __builtin_bswap64(value) : value);
    }
    at += 4 + (size + 3) / 4 * 4;
  }
  interfaces_.push_back(interface);
  return true;
}

void CaptureFile::read_packet(std::uint32_t type, ByteView body, CapturedFrame& frame) const {
  frame = {};
  frame.broken = true;
  const bool simple = type == simple_packet;
  const std::size_t head_bytes = simple ? 4 : 20;
  if (body.size() < head_bytes) return;
  std::size_t number = 0;  // of the interface: a simple packet is of the first
  if (!simple) number = type == old_packet ? u16(body, 0) : u32(body, 0);
  if (number >= interfaces_.size()) return;
  const Interface& interface = interfaces_[number];
  frame.link_type = interface.link_type;
  frame.wire_bytes = u32(body, simple ? 0 : 16);
  std::size_t size = simple ? frame.wire_bytes : u32(body, 12);
  const std::size_t there = body.size() - head_bytes;
  if (simple && size > there) size = there;  // cut; the padding cannot be told from the bytes then
  if (size > there) return;
  if (!simple) frame.stamp_ns = stamp_ns(interface, std::uint64_t{u32(body, 4)} << 32U | u32(body, 8));
  frame.broken = false;
  frame.bytes = body.subspan(head_bytes, size);
}

std::optional<std::int64_t> CaptureFile::stamp_ns(const Interface& interface, std::uint64_t ticks) {
  const unsigned exponent = interface.resolution & 0x7FU;
  std::uint64_t seconds = 0;
  std::uint64_t fraction_ns = 0;
  if (interface.resolution >= 0x80) {
    if (exponent > 63) return std::nullopt;
    seconds = ticks >> exponent;
    std::uint64_t fraction = ticks & ((std::uint64_t{1} << exponent) - 1);
    // 2^34 times 10^9 fits into 64 bits; finer than that is far below a nanosecond.
    const unsigned used = exponent > 34 ? 34 : exponent;
    fraction >>= exponent - used;
    fraction_ns = (fraction * ns_per_second) >> used;
  } else {
    if (exponent > 19) return std::nullopt;
    const std::uint64_t ticks_per_s = power_of_ten(exponent);
    seconds = ticks / ticks_per_s;
    const std::uint64_t fraction = ticks % ticks_per_s;
    fraction_ns = exponent <= 9 ? fraction * power_of_ten(9 - exponent) : fraction / power_of_ten(exponent - 9);
  }
  const auto most = static_cast<std::uint64_t>(max_seconds);
  if (seconds > most || interface.offset_s > max_seconds || interface.offset_s < -max_seconds) return std::nullopt;
  const std::int64_t whole = static_cast<std::int64_t>(seconds) + interface.offset_s;
  if (whole < 0 || whole > max_seconds) return std::nullopt;
  return whole * ns_per_second + static_cast<std::int64_t>(fraction_ns);
}

}  // namespace rigcal
