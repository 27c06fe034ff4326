#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/input_file.h"
#include "core/io/ip_reassembler.h"
#include "core/records/records.h"

namespace rigcal {

/// What a dump held beside the datagrams that were delivered. Every frame is in one of these lines.
struct PcapCounters {
  std::uint64_t frames = 0;      ///< All frames read.
  std::uint64_t datagrams = 0;   ///< UDP over IPv4, delivered; also those put together from fragments.
  std::uint64_t ipv6 = 0;        ///< Left out: Livox LiDARs speak IPv4 only.
  std::uint64_t not_udp = 0;     ///< ARP, TCP and so on.
  std::uint64_t cut = 0;         ///< Not whole, because the snapshot length of the recording was too small.
  std::uint64_t other_link = 0;  ///< From an interface of a link type that is not read.
  std::uint64_t malformed = 0;   ///< Headers that contradict each other, or no stamp.
  FragmentCounters parts;        ///< Frames that were fragments of IP packets.

  PcapCounters& operator+=(const PcapCounters& more);
};

/// What a user should know of these counts, in clauses: what is missing, and why.
[[nodiscard]] std::vector<std::string> capture_findings(const PcapCounters& counters);

/// Streams the UDP datagrams of a packet dump: pcap (micro- and nanosecond, both byte orders) and pcapng (several
/// interfaces); Ethernet with VLAN tags, raw IP, Linux cooked v1 and v2, null and loop; fragments are put together.
/// Stamps are those of the file, for a packet in fragments that of the last to come. Not thread-safe.
class PcapReader {
 public:
  /// Errors: missing, no permission, empty, not a capture file.
  [[nodiscard]] static Expected<PcapReader> open(const std::string& path);
  /// The same for a dump that is still being written: `next` waits for a whole packet. Returns at once only where its
  /// first bytes are there.
  [[nodiscard]] static Expected<PcapReader> follow(const std::string& path, AwaitGrowth await_growth);

  PcapReader(PcapReader&&) noexcept;
  PcapReader& operator=(PcapReader&&) noexcept;
  PcapReader(const PcapReader&) = delete;
  PcapReader& operator=(const PcapReader&) = delete;
  ~PcapReader();

  /// The next datagram; false at the end. `datagram.bytes` lives until the next call. A dump that is cut or damaged in
  /// the middle ends there without an error, since what is whole is of use: ask `truncated()`. Errors: damage before
  /// the first frame; nothing but frames of a link type that is not read; `read_failure`.
  [[nodiscard]] Expected<bool> next(Datagram& datagram);

  /// True once the end was reached and was no proper end.
  [[nodiscard]] bool truncated() const;
  /// Where and why a truncated dump ended, one clause for a warning; empty otherwise.
  [[nodiscard]] const std::string& truncation() const;
  [[nodiscard]] const PcapCounters& counters() const;

 private:
  struct State;
  explicit PcapReader(std::unique_ptr<State> state);
  Expected<bool> end();
  std::unique_ptr<State> state_;
};

}  // namespace rigcal
