#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/records/records.h"
#include "tests/support/files.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {

using Bytes = std::vector<std::uint8_t>;

inline std::string write_bytes(const std::string& name, const Bytes& bytes) {
  const std::string path = fresh_path(name);
  save_bytes(path, bytes);
  return path;
}

inline std::string write_text(const std::string& name, const std::string& text) {
  return write_bytes(name, Bytes(text.begin(), text.end()));
}

inline Bytes join(const std::vector<Bytes>& parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

/// An unsigned value of `size` bytes.
inline Bytes number(std::uint64_t value, std::size_t size, bool big_endian) {
  Bytes bytes;
  for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// An IPv4 packet 192.168.1.5:55000 -> 192.168.1.50:60001 written down from RFC 791 and 768, not by the writer.
inline Bytes ip_udp(const Bytes& payload, std::uint16_t fragment_field = 0x4000, std::uint8_t protocol = 17) {
  return join({{0x45, 0},
               number(28 + payload.size(), 2, true),
               {0, 1},
               number(fragment_field, 2, true),
               {64, protocol, 0, 0, 192, 168, 1, 5, 192, 168, 1, 50},
               number(55000, 2, true),
               number(60001, 2, true),
               number(8 + payload.size(), 2, true),
               {0, 0},
               payload});
}

/// The IPv4 packet `ip_udp(payload)` in pieces of `piece_bytes` (a multiple of 8).
inline std::vector<Bytes> fragments(const Bytes& payload, std::size_t piece_bytes) {
  const Bytes whole = ip_udp(payload);
  std::vector<Bytes> pieces;
  for (std::size_t at = 20; at < whole.size(); at += piece_bytes) {
    const std::size_t end = std::min(at + piece_bytes, whole.size());
    const auto begin = whole.begin() + static_cast<std::ptrdiff_t>(at);
    Bytes head(whole.begin(), whole.begin() + 20);
    const std::size_t field = (at - 20) / 8 + (end < whole.size() ? 0x2000 : 0);
    const Bytes size = number(20 + end - at, 2, true);
    const Bytes place = number(field, 2, true);
    std::copy(size.begin(), size.end(), head.begin() + 2);
    std::copy(place.begin(), place.end(), head.begin() + 6);
    pieces.push_back(join({head, Bytes(begin, whole.begin() + static_cast<std::ptrdiff_t>(end))}));
  }
  return pieces;
}

/// A classic capture file. `frames` are whole frames of the link type; frame i has the stamp 1600000000 s + i units.
inline Bytes pcap_file(std::uint32_t link_type, const std::vector<Bytes>& frames, bool nano = true, bool big = false) {
  Bytes file = join({number(nano ? 0xA1B23C4D : 0xA1B2C3D4, 4, big), number(2, 2, big), number(4, 2, big),
                     number(0, 8, big), number(262144, 4, big), number(link_type, 4, big)});
  for (std::size_t i = 0; i < frames.size(); ++i) {
    file = join({file, number(1'600'000'000, 4, big), number(i, 4, big), number(frames[i].size(), 4, big),
                 number(frames[i].size(), 4, big), frames[i]});
  }
  return file;
}

inline Bytes ethernet(const Bytes& packet, std::uint16_t type = 0x0800) {
  return join({{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, number(type, 2, true), packet});
}

}  // namespace rigcal
