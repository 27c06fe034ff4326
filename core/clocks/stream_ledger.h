#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace rigcal {

/// A place where packets are missing.
struct StreamGap {
  std::int64_t start_ns = 0;   ///< Session time at which the first missing packet was due.
  std::int64_t length_ns = 0;  ///< From then to the next packet that came, by the device's clock.
  std::uint64_t lost = 0;      ///< Packets.
};

/// The book of one stream. A packet that came damaged leaves a hole like one that never came: it is in `damaged`, and
/// where packets around it came, in `lost` too.
struct StreamCounters {
  std::uint64_t received = 0;  ///< With a sensible stamp; duplicates included.
  std::uint64_t lost = 0;
  std::uint64_t duplicated = 0;
  std::uint64_t out_of_order = 0;  ///< Came after a packet that was sent later.
  std::uint64_t damaged = 0;       ///< Came, but could not be read or had a senseless stamp.
  std::uint64_t too_late = 0;      ///< Came when the book of their time was closed: new or duplicate, nobody knows.
  std::uint64_t restarts = 0;      ///< Jumps of the device's clock; what was lost there is not known.
  std::uint64_t gaps = 0;

  /// Packets that the device has sent, as far as its stamps tell.
  [[nodiscard]] std::uint64_t expected() const { return received - duplicated - too_late + lost; }
};

/// All that the ledger knows.
struct StreamBook : StreamCounters {
  std::vector<StreamGap> listed_gaps;  ///< The first that were not filled again, in the order of the device's time.
  StreamGap longest_gap;               ///< Of all; of no length where there is none.
};

enum class Arrival { in_order, late, duplicate };

/// Keeps the book of one stream (the points, or the IMU) of one device by its stamps: packets carry no number. The last
/// `kOpen` packets stay open for what comes late or twice; memory is bounded. Exact, for any order of arrival within
/// them, but for what stamps cannot tell:
///
/// - what was lost before the first packet that came and after the last one;
/// - what was lost where the device's clock jumped, and what came before the jump was believed;
/// - packets whose stamp was damaged into another sensible one.
class StreamLedger {
 public:
  static constexpr std::size_t kListedGaps = 100;
  /// More than all streams of a device send in the 50 ms after which DeviceClock takes a packet for a stray.
  static constexpr std::size_t kOpen = 512;

  /// `interval_ns` is how long after this packet the next one is due. A gap is more than 1.8 intervals without a
  /// packet; one that comes late after all is taken out of the loss.
  Arrival add(std::int64_t device_ns, double interval_ns, std::int64_t session_ns);
  /// A packet came and was of no use.
  void add_damaged() { ++counters_.damaged; }
  /// The device's clock has jumped: the next packet is the first again.
  void restart();

  [[nodiscard]] const StreamCounters& counters() const { return counters_; }
  [[nodiscard]] StreamBook book() const;

 private:
  struct Packet {
    std::int64_t device_ns = 0;
    std::int64_t session_ns = 0;
    double interval_ns = 0.0;
  };

  [[nodiscard]] static std::uint64_t missing_between(const Packet& before, const Packet& after);
  [[nodiscard]] static StreamGap gap_between(const Packet& before, const Packet& after);
  Arrival add_late(const Packet& packet);
  void open(const Packet& before, const Packet& after);
  void close(const Packet& before, const Packet& after);
  void note(const StreamGap& gap);
  void settle_oldest();

  StreamCounters counters_;
  std::deque<Packet> open_;  ///< In the order of the device's time.
  bool is_settled_ = false;  ///< Packets before the first of `open_` have come.
  std::vector<StreamGap> settled_;
  StreamGap longest_;
};

}  // namespace rigcal
