#include "core/io/ip_reassembler.h"

#include <algorithm>
#include <cstring>

namespace rigcal {
namespace {

constexpr std::size_t unit_bytes = 8;
/// Of an IP packet without its shortest header.
constexpr std::size_t max_data_bytes = 65535 - 20;

std::size_t units(std::size_t bytes) { return (bytes + unit_bytes - 1) / unit_bytes; }

bool of_one_packet(const IpPart& a, const IpPart& b) { return a.id == b.id && a.from == b.from && a.to == b.to; }

}  // namespace

void IpReassembler::give_up(std::size_t index) {
  if (!waiting_[index].refused) ++counters_.incomplete;
  waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(index));
}

void IpReassembler::give_up_old(std::int64_t stamp_ns) {
  for (std::size_t i = waiting_.size(); i-- > 0;) {
    const std::int64_t start = waiting_[i].start_ns;
    const bool old = start < stamp_ns - max_wait_ns || stamp_ns < start - max_wait_ns;
    if (old) give_up(i);
  }
}

std::size_t IpReassembler::find_or_add(const IpPart& fragment, std::int64_t stamp_ns) {
  const auto found = std::find_if(waiting_.begin(), waiting_.end(), [&fragment](const Packet& packet) {
    return of_one_packet(packet.first_seen, fragment);
  });
  if (found != waiting_.end()) return static_cast<std::size_t>(found - waiting_.begin());
  if (waiting_.size() >= max_waiting) {
    if (!waiting_.front().refused) ++counters_.crowded_out;
    waiting_.erase(waiting_.begin());
  }
  Packet& packet = waiting_.emplace_back();
  packet.first_seen = fragment;
  packet.first_seen.data = {};
  packet.start_ns = stamp_ns;
  return waiting_.size() - 1;
}

bool IpReassembler::fits(const Packet& packet, const IpPart& fragment) {
  const std::size_t end = fragment.offset + fragment.data.size();
  if (fragment.data.empty() || end > max_data_bytes) return false;
  if (fragment.more_to_come) return fragment.data.size() % unit_bytes == 0 && (!packet.length || end <= *packet.length);
  return packet.length ? end == *packet.length : end >= packet.bytes.size();
}

bool IpReassembler::merge(Packet& packet, const IpPart& fragment) {
  if (!fits(packet, fragment)) return false;
  const std::size_t end = fragment.offset + fragment.data.size();
  if (!fragment.more_to_come) packet.length = end;
  if (end > packet.bytes.size()) {
    packet.bytes.resize(end);
    packet.have.resize(units(end), false);
  }
  bool news = false;
  for (std::size_t at = fragment.offset; at < end; at += unit_bytes) {
    const std::size_t size = std::min(unit_bytes, end - at);
    std::uint8_t* const to = packet.bytes.data() + at;
    const std::uint8_t* const from = fragment.data.data() + (at - fragment.offset);
    if (packet.have[at / unit_bytes]) {
      if (std::memcmp(to, from, size) != 0) return false;
      continue;
    }
    std::memcpy(to, from, size);
    packet.have[at / unit_bytes] = true;
    ++packet.have_units;
    news = true;
  }
  if (!news) ++counters_.duplicates;
  return true;
}

std::optional<IpPart> IpReassembler::add(const IpPart& fragment, std::int64_t stamp_ns) {
  ++counters_.fragments;
  give_up_old(stamp_ns);
  const std::size_t index = find_or_add(fragment, stamp_ns);
  Packet& packet = waiting_[index];
  if (packet.refused) return std::nullopt;
  if (!merge(packet, fragment)) {
    ++counters_.contradictory;
    packet.refused = true;
    packet.bytes = {};
    packet.have = {};
    return std::nullopt;
  }
  if (!packet.length || packet.have_units < units(*packet.length)) return std::nullopt;
  whole_ = std::move(packet.bytes);
  IpPart whole = packet.first_seen;
  whole.offset = 0;
  whole.more_to_come = false;
  whole.data = whole_;
  waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(index));
  ++counters_.whole;
  return whole;
}

void IpReassembler::finish() {
  while (!waiting_.empty()) give_up(waiting_.size() - 1);
}

FragmentCounters& FragmentCounters::operator+=(const FragmentCounters& more) {
  fragments += more.fragments;
  duplicates += more.duplicates;
  whole += more.whole;
  incomplete += more.incomplete;
  contradictory += more.contradictory;
  crowded_out += more.crowded_out;
  return *this;
}

}  // namespace rigcal
