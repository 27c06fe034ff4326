#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/io/link_layer.h"

namespace rigcal {

/// What became of the fragments of IPv4 packets; all but the first two lines count packets.
struct FragmentCounters {
  std::uint64_t fragments = 0;
  std::uint64_t duplicates = 0;     ///< Fragments that said nothing new.
  std::uint64_t whole = 0;          ///< Put together.
  std::uint64_t incomplete = 0;     ///< Parts were missing when their time was over.
  std::uint64_t contradictory = 0;  ///< Parts overlap with other bytes, disagree on the length or fit into no packet.
  std::uint64_t crowded_out = 0;    ///< Given up for newer ones, because too many were waiting.

  [[nodiscard]] std::uint64_t lost() const { return incomplete + contradictory + crowded_out; }
  FragmentCounters& operator+=(const FragmentCounters& more);
};

/// Puts fragmented IPv4 packets together again (RFC 791, section 3.2), whatever the order of their fragments. Where
/// fragments overlap they must agree in every byte, otherwise the whole packet is refused: no rule of whose bytes count
/// can then be played off against another machine's. Memory is bounded: `max_waiting` packets of 64 KiB. A function of
/// parts and stamps only.
class IpReassembler {
 public:
  /// Packets that may wait for fragments at a time; then the oldest is given up.
  static constexpr std::size_t max_waiting = 64;
  /// Fragments of a packet come within milliseconds, and after some seconds its number is used again.
  static constexpr std::int64_t max_wait_ns = 2'000'000'000;

  /// The whole of the packet where this was its last missing fragment: offset 0, with `data` that lives until the next
  /// call. Stamps may go back.
  [[nodiscard]] std::optional<IpPart> add(const IpPart& fragment, std::int64_t stamp_ns);
  /// No more fragments: what waits is counted as incomplete.
  void finish();
  [[nodiscard]] const FragmentCounters& counters() const { return counters_; }

 private:
  struct Packet {
    IpPart first_seen;  ///< Tells whose packet it is.
    std::int64_t start_ns = 0;
    bool refused = false;  ///< Kept to swallow its later fragments.
    std::vector<std::uint8_t> bytes;
    std::vector<bool> have;  ///< Of each 8 bytes, the unit in which offsets count.
    std::size_t have_units = 0;
    std::optional<std::size_t> length;  ///< Known with the last fragment.
  };

  void give_up_old(std::int64_t stamp_ns);
  std::size_t find_or_add(const IpPart& fragment, std::int64_t stamp_ns);
  void give_up(std::size_t index);
  static bool fits(const Packet& packet, const IpPart& fragment);
  bool merge(Packet& packet, const IpPart& fragment);

  std::vector<Packet> waiting_;  ///< In the order of their first fragments.
  std::vector<std::uint8_t> whole_;
  FragmentCounters counters_;
};

}  // namespace rigcal
