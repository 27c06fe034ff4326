#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/records/records.h"

namespace rigcal::sim {

/// Takes a datagram; an error ends the run and is handed on. `bytes` lives until it returns.
using DatagramSink = std::function<Expected<void>(const Datagram&)>;

/// What goes wrong between the sensors and the recording. Shares of all sample packets; a packet has one fault at most.
struct FaultOptions {
  double loss = 0.0;
  double duplicate = 0.0;         ///< Comes a second time, up to `window` packets of its stream later.
  double reorder = 0.0;           ///< Is overtaken by 1 to `window` packets of its stream.
  double delay = 0.0;             ///< Comes up to `longest_delay_s` later.
  double flip = 0.0;              ///< One bit of the datagram, any, is wrong.
  int window = 8;                 ///< 1 at least.
  double longest_delay_s = 0.02;  ///< Nothing comes later than this, reordered ones and doubles neither.

  [[nodiscard]] bool any() const { return loss + duplicate + reorder + delay + flip > 0.0; }
};

/// What was done to one stream (an address and port that sends).
struct FaultCounts {
  std::uint64_t sent = 0;
  std::uint64_t lost = 0;
  std::uint64_t lost_at_start = 0;  ///< Of these: before the first that was not,
  std::uint64_t lost_at_end = 0;    ///< and after the last. No receiver can know of them.
  std::uint64_t gaps = 0;           ///< Runs of losses between packets that were not lost.
  std::uint64_t duplicated = 0;
  std::uint64_t out_of_order = 0;  ///< Came after one that was sent later: reordered, or delayed for long enough.
  std::uint64_t delayed = 0;
  std::uint64_t flipped = 0;

  /// Datagrams that came out, duplicates included.
  [[nodiscard]] std::uint64_t received() const { return sent - lost + duplicated; }
};

/// Loses, doubles, reorders, delays and damages sample packets, and knows exactly what it did. A function of options,
/// seed and datagrams; each stream has its own random numbers. Datagrams that are no sample packets pass as they are.
/// The stamps that come out are in order when those that go in are.
class PacketFaults {
 public:
  PacketFaults(const FaultOptions& options, std::uint64_t seed, DatagramSink sink);

  Expected<void> add(const Datagram& datagram);
  /// The end: what is still on its way arrives.
  Expected<void> flush();

  [[nodiscard]] const std::map<Endpoint, FaultCounts>& counts() const { return counts_; }

 private:
  struct Stream {
    Random random;
    std::uint64_t newest = 0;  ///< Number of the latest packet that arrived, from 1 on.
    std::uint64_t lost_since_kept = 0;
    bool any_kept = false;
  };
  /// A datagram on its way: until `overtakers` of its stream have arrived (where there are any), or until `due_ns`.
  struct Held {
    std::int64_t due_ns = 0;
    int overtakers = 0;
    std::uint64_t number = 0;
    bool copy = false;
    Endpoint from;
    Endpoint to;
    std::vector<std::uint8_t> bytes;
  };

  Stream& stream_of(const Endpoint& from);
  void lose(Stream& stream, FaultCounts& counts);
  void keep(Stream& stream, FaultCounts& counts);
  Expected<void> arrive(const Datagram& datagram, std::uint64_t number, bool copy);
  Expected<void> arrive(const Held& held, std::int64_t stamp_ns);
  Expected<void> release_due(std::int64_t now_ns);
  Expected<void> release_overtaken(const Endpoint& from, std::int64_t now_ns);
  void hold(const Datagram& datagram, std::uint64_t number, bool copy, int overtakers, double longest_s);

  FaultOptions options_;
  std::uint64_t seed_;
  DatagramSink sink_;
  std::map<Endpoint, Stream> streams_;
  std::map<Endpoint, FaultCounts> counts_;
  std::vector<Held> held_;
  std::vector<std::uint8_t> damaged_;
};

}  // namespace rigcal::sim
