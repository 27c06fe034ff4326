#include "simdata/packets/packet_faults.h"

#include <algorithm>
#include <utility>

#include "core/base/seconds.h"

namespace rigcal::sim {
namespace {

constexpr std::uint64_t fault_stream = 1ULL << 60U;
constexpr std::uint8_t sample_version = 5;

// The first byte of a sample packet is its version; control frames begin with 0xAA.
bool is_sample_packet(const Datagram& datagram) {
  return !datagram.bytes.empty() && datagram.bytes[0] == sample_version;
}

std::uint64_t number_of(const Endpoint& endpoint) {
  std::uint64_t number = endpoint.port;
  for (const std::uint8_t byte : endpoint.ip) number = (number << 8U) | byte;
  return number;
}

}  // namespace

PacketFaults::PacketFaults(const FaultOptions& options, std::uint64_t seed, DatagramSink sink)
    : options_(options), seed_(seed), sink_(std::move(sink)) {
  RIGCAL_ASSERT(options.window >= 1, "a window of no packets");
}

PacketFaults::Stream& PacketFaults::stream_of(const Endpoint& from) {
  const auto found = streams_.find(from);
  if (found != streams_.end()) return found->second;
  return streams_.emplace(from, Stream{Random(seed_, fault_stream | number_of(from)), 0, 0, false}).first->second;
}

void PacketFaults::lose(Stream& stream, FaultCounts& counts) {
  ++counts.lost;
  ++stream.lost_since_kept;
  ++(stream.any_kept ? counts.lost_at_end : counts.lost_at_start);
}

void PacketFaults::keep(Stream& stream, FaultCounts& counts) {
  if (stream.any_kept && stream.lost_since_kept > 0) ++counts.gaps;
  stream.any_kept = true;
  stream.lost_since_kept = 0;
  counts.lost_at_end = 0;
}

Expected<void> PacketFaults::add(const Datagram& datagram) {
  if (const auto released = release_due(datagram.stamp_ns); !released) return released;
  if (!is_sample_packet(datagram)) return sink_(datagram);
  Stream& stream = stream_of(datagram.from);
  FaultCounts& counts = counts_[datagram.from];
  const std::uint64_t number = ++counts.sent;
  double fate = options_.any() ? stream.random.uniform() : 1.0;
  const auto strikes = [&fate](double share) {
    const bool yes = fate >= 0.0 && fate < share;
    fate -= share;
    return yes;
  };
  if (strikes(options_.loss)) {
    lose(stream, counts);
    return {};
  }
  keep(stream, counts);
  const auto window = static_cast<std::uint64_t>(options_.window);
  if (strikes(options_.reorder)) {
    hold(datagram, number, false, 1 + static_cast<int>(stream.random.below(window)), options_.longest_delay_s);
    return {};
  }
  if (strikes(options_.delay)) {
    ++counts.delayed;
    hold(datagram, number, false, 0, stream.random.uniform() * options_.longest_delay_s);
    return {};
  }
  const bool twice = strikes(options_.duplicate);
  Datagram arriving = datagram;
  if (strikes(options_.flip)) {
    ++counts.flipped;
    damaged_.assign(datagram.bytes.begin(), datagram.bytes.end());
    const std::uint64_t bit = stream.random.below(damaged_.size() * 8);
    damaged_[bit / 8] = static_cast<std::uint8_t>(damaged_[bit / 8] ^ (1U << (bit % 8)));
    arriving.bytes = damaged_;
  }
  if (const auto arrived = arrive(arriving, number, false); !arrived) return arrived;
  if (const auto released = release_overtaken(datagram.from, datagram.stamp_ns); !released) return released;
  if (!twice) return {};
  const int later = static_cast<int>(stream.random.below(window + 1));
  if (later == 0) return arrive(datagram, number, true);
  hold(datagram, number, true, later, options_.longest_delay_s);
  return {};
}

void PacketFaults::hold(const Datagram& datagram, std::uint64_t number, bool copy, int overtakers, double longest_s) {
  held_.push_back({datagram.stamp_ns + ns_of_seconds(longest_s), overtakers, number, copy, datagram.from, datagram.to,
                   std::vector<std::uint8_t>(datagram.bytes.begin(), datagram.bytes.end())});
}

Expected<void> PacketFaults::arrive(const Datagram& datagram, std::uint64_t number, bool copy) {
  Stream& stream = stream_of(datagram.from);
  FaultCounts& counts = counts_[datagram.from];
  if (copy) {
    ++counts.duplicated;
  } else if (number < stream.newest) {
    ++counts.out_of_order;
  }
  stream.newest = std::max(stream.newest, number);
  return sink_(datagram);
}

Expected<void> PacketFaults::arrive(const Held& held, std::int64_t stamp_ns) {
  return arrive({stamp_ns, held.from, held.to, held.bytes}, held.number, held.copy);
}

Expected<void> PacketFaults::release_due(std::int64_t now_ns) {
  if (held_.empty()) return {};
  const auto due =
      std::stable_partition(held_.begin(), held_.end(), [&](const Held& held) { return held.due_ns > now_ns; });
  if (due == held_.end()) return {};
  std::vector<Held> ready(std::make_move_iterator(due), std::make_move_iterator(held_.end()));
  held_.erase(due, held_.end());
  std::stable_sort(ready.begin(), ready.end(), [](const Held& a, const Held& b) { return a.due_ns < b.due_ns; });
  for (const Held& held : ready) {
    if (const auto arrived = arrive(held, held.due_ns); !arrived) return arrived;
  }
  return {};
}

Expected<void> PacketFaults::release_overtaken(const Endpoint& from, std::int64_t now_ns) {
  if (held_.empty()) return {};
  for (Held& held : held_) {
    if (held.from == from && held.overtakers > 0 && --held.overtakers == 0) held.due_ns = now_ns;
  }
  const auto ready = std::stable_partition(held_.begin(), held_.end(),
                                           [&](const Held& held) { return held.from != from || held.due_ns > now_ns; });
  const std::vector<Held> overtaken(std::make_move_iterator(ready), std::make_move_iterator(held_.end()));
  held_.erase(ready, held_.end());
  for (const Held& held : overtaken) {
    if (const auto arrived = arrive(held, now_ns); !arrived) return arrived;
  }
  return {};
}

Expected<void> PacketFaults::flush() { return release_due(INT64_MAX); }

}  // namespace rigcal::sim
