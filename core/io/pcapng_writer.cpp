#include "core/io/pcapng_writer.h"

#include <array>
#include <cstring>

#include "core/io/link_layer.h"

namespace rigcal {
namespace {

// Block types and layouts: draft-ietf-opsawg-pcapng, sections 4.1 to 4.3.
constexpr std::uint32_t section_header_block = 0x0A0D0D0A;
constexpr std::uint32_t interface_description_block = 1;
constexpr std::uint32_t enhanced_packet_block = 6;
constexpr std::uint16_t linktype_raw = 101;

constexpr std::size_t packet_block_head = 28;
constexpr std::size_t ip_header_bytes = 20;
constexpr std::size_t max_payload_bytes = 65535 - ip_header_bytes - udp_header_bytes;

/// Fills reserved room from front to back.
class Filler {
 public:
  explicit Filler(std::uint8_t* at) : at_(at) {}

  template <class T>
  void little(T value) {
    std::memcpy(at_, &value, sizeof(T));
    at_ += sizeof(T);
  }
  void big_16(std::size_t value) {
    *at_++ = static_cast<std::uint8_t>(value >> 8);
    *at_++ = static_cast<std::uint8_t>(value);
  }
  void bytes(const std::uint8_t* from, std::size_t size) {
    if (size > 0) std::memcpy(at_, from, size);
    at_ += size;
  }
  void zeros(std::size_t size) {
    std::memset(at_, 0, size);
    at_ += size;
  }
  [[nodiscard]] std::uint8_t* at() const { return at_; }

 private:
  std::uint8_t* at_;
};

void write_file_head(OutputFile& file) {
  constexpr std::uint32_t section_size = 28 + 12 + 4;
  constexpr std::uint32_t interface_size = 20 + 8 + 4;
  Filler out(file.reserve(section_size + interface_size));
  out.little(section_header_block);
  out.little(section_size);
  out.little<std::uint32_t>(0x1A2B3C4D);
  out.little<std::uint16_t>(1);  // version 1.0
  out.little<std::uint16_t>(0);
  out.little<std::int64_t>(-1);  // length of the section: not known
  constexpr std::array<std::uint8_t, 8> program{'r', 'i', 'g', 'c', 'a', 'l', 0, 0};
  out.little<std::uint16_t>(4);  // shb_userappl
  out.little<std::uint16_t>(6);
  out.bytes(program.data(), program.size());
  out.little<std::uint32_t>(0);  // opt_endofopt
  out.little(section_size);

  out.little(interface_description_block);
  out.little(interface_size);
  out.little(linktype_raw);
  out.little<std::uint16_t>(0);
  out.little<std::uint32_t>(0);  // no snapshot length
  out.little<std::uint16_t>(9);  // if_tsresol
  out.little<std::uint16_t>(1);
  out.little<std::uint32_t>(9);  // 10^-9 s, padded
  out.little<std::uint32_t>(0);  // opt_endofopt
  out.little(interface_size);
}

/// RFC 1071 over the header of 20 bytes.
std::uint16_t ip_checksum(const std::uint8_t* header) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < ip_header_bytes; i += 2)
    sum += static_cast<std::uint32_t>(header[i] << 8) | header[i + 1];
  sum = (sum & 0xFFFF) + (sum >> 16);
  sum = (sum & 0xFFFF) + (sum >> 16);
  return static_cast<std::uint16_t>(~sum);
}

void fill_ip_and_udp(Filler& out, const Datagram& datagram) {
  std::uint8_t* const header = out.at();
  const std::size_t udp_bytes = udp_header_bytes + datagram.bytes.size();
  out.little<std::uint8_t>(0x45);
  out.little<std::uint8_t>(0);
  out.big_16(ip_header_bytes + udp_bytes);
  out.big_16(0);       // identification: never fragmented
  out.big_16(0x4000);  // do not fragment
  out.little<std::uint8_t>(64);
  out.little<std::uint8_t>(17);
  out.big_16(0);
  out.bytes(datagram.from.ip.data(), 4);
  out.bytes(datagram.to.ip.data(), 4);
  Filler(header + 10).big_16(ip_checksum(header));
  out.big_16(datagram.from.port);
  out.big_16(datagram.to.port);
  out.big_16(udp_bytes);
  out.big_16(0);
}

}  // namespace

Expected<PcapngWriter> PcapngWriter::create(const std::string& path) {
  Expected<OutputFile> file = OutputFile::create(path);
  if (!file) return file.error();
  write_file_head(*file);
  return PcapngWriter(std::move(*file));
}

Expected<void> PcapngWriter::write(const Datagram& datagram) {
  if (datagram.bytes.size() > max_payload_bytes) {
    return input_error("a payload of " + std::to_string(datagram.bytes.size()) + " bytes fits into no UDP datagram",
                       "datagram " + std::to_string(datagrams_));
  }
  if (datagram.stamp_ns < 0) {
    return input_error("a stamp before 1970 cannot be stored", "datagram " + std::to_string(datagrams_));
  }
  const std::size_t packet = ip_header_bytes + udp_header_bytes + datagram.bytes.size();
  const std::size_t padding = (4 - packet % 4) % 4;
  const std::size_t block = packet_block_head + packet + padding + 4;
  const auto stamp = static_cast<std::uint64_t>(datagram.stamp_ns);
  Filler out(file_.reserve(block));
  out.little(enhanced_packet_block);
  out.little(static_cast<std::uint32_t>(block));
  out.little<std::uint32_t>(0);  // the only interface
  out.little(static_cast<std::uint32_t>(stamp >> 32));
  out.little(static_cast<std::uint32_t>(stamp));
  out.little(static_cast<std::uint32_t>(packet));
  out.little(static_cast<std::uint32_t>(packet));
  fill_ip_and_udp(out, datagram);
  out.bytes(datagram.bytes.data(), datagram.bytes.size());
  out.zeros(padding);
  out.little(static_cast<std::uint32_t>(block));
  ++datagrams_;
  return file_.status();
}

}  // namespace rigcal
