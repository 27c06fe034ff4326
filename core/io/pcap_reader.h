#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/base/error.h"
#include "core/records/records.h"

namespace rigcal {

/// What a dump held beside the datagrams that were delivered.
struct PcapCounters {
  std::uint64_t frames = 0;     ///< All frames read.
  std::uint64_t datagrams = 0;  ///< UDP over IPv4, delivered.
  std::uint64_t not_udp = 0;    ///< ARP, IPv6, TCP and so on.
  std::uint64_t fragments = 0;  ///< Parts of fragmented IP packets, left out.
  std::uint64_t malformed = 0;  ///< Cut by the snapshot length, or headers that contradict each other.
};

/// Streams the UDP datagrams of a packet dump: pcap (micro- and nanosecond, both byte orders) and pcapng; Ethernet with
/// VLAN tags, raw IP, Linux cooked v1 and v2, null and loop. Stamps are those of the file. Not thread-safe.
class PcapReader {
 public:
  /// Errors: missing, no permission, empty, not a capture file, a link type that is not read.
  [[nodiscard]] static Expected<PcapReader> open(const std::string& path);

  PcapReader(PcapReader&&) noexcept;
  PcapReader& operator=(PcapReader&&) noexcept;
  PcapReader(const PcapReader&) = delete;
  PcapReader& operator=(const PcapReader&) = delete;
  ~PcapReader();

  /// The next datagram; false at the end. `datagram.bytes` lives until the next call. A dump that is cut or damaged in
  /// the middle ends there without an error, since what is whole is of use: ask `truncated()`. Damage before the first
  /// frame is an error.
  [[nodiscard]] Expected<bool> next(Datagram& datagram);

  /// True once the end was reached and was no proper end.
  [[nodiscard]] bool truncated() const;
  /// Where and why a truncated dump ended, one clause for a warning; empty otherwise.
  [[nodiscard]] const std::string& truncation() const;
  [[nodiscard]] const PcapCounters& counters() const;

 private:
  struct State;
  explicit PcapReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace rigcal
