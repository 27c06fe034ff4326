#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/records/records.h"

namespace rigcal::livox {

/// Datagrams on their way from one thread to one other, in memory that was asked for before. What does not fit is
/// counted and dropped: the thread that receives never waits.
class DatagramRing {
 public:
  static constexpr std::size_t kLongest = 1472;  ///< A full Ethernet frame; no Livox datagram is longer than 1400.

  /// Room for `datagrams`, rounded up to a power of two.
  explicit DatagramRing(std::size_t datagrams);

  /// Takes its memory and touches it, so that no datagram waits for the system to find it: tens of milliseconds. Before
  /// the first `push`, which does it otherwise. A ring that is not used takes none.
  void take_memory();
  /// From the one thread. False where there is no room or the datagram is too long; both are counted.
  bool push(const Datagram& datagram);
  /// From the other thread: the oldest one, or nothing. It lives until `pop`.
  [[nodiscard]] bool peek(Datagram& datagram) const;
  void pop();

  /// Datagrams that were taken in.
  [[nodiscard]] std::uint64_t pushed() const { return pushed_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }
  /// The most that have waited at once.
  [[nodiscard]] std::size_t high_water() const { return high_water_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }

 private:
  struct Slot {
    std::int64_t stamp_ns = 0;
    Endpoint from;
    Endpoint to;
    std::uint32_t size = 0;
    std::array<std::uint8_t, kLongest> bytes;
  };

  std::size_t capacity_;
  std::vector<Slot> slots_;  ///< None until `take_memory`, then all.
  alignas(64) std::atomic<std::uint64_t> pushed_{0};
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<std::size_t> high_water_{0};
  alignas(64) std::atomic<std::uint64_t> popped_{0};
};

}  // namespace rigcal::livox
