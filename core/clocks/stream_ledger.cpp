#include "core/clocks/stream_ledger.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace rigcal {
namespace {

// The public driver's rule for these sensors: less is jitter of the stamps, more is a packet that is missing.
constexpr double gap_intervals = 1.8;

// Stamps come from the wire: what is made of them may not fit.
constexpr double most = 9e18;

}  // namespace

std::uint64_t StreamLedger::missing_between(const Packet& before, const Packet& after) {
  const auto distance = static_cast<std::uint64_t>(after.device_ns) - static_cast<std::uint64_t>(before.device_ns);
  const double intervals = static_cast<double>(distance) / before.interval_ns;
  return intervals > gap_intervals ? static_cast<std::uint64_t>(std::round(std::min(intervals, most))) - 1 : 0;
}

StreamGap StreamLedger::gap_between(const Packet& before, const Packet& after) {
  const auto distance = static_cast<std::uint64_t>(after.device_ns) - static_cast<std::uint64_t>(before.device_ns);
  const double length = static_cast<double>(distance) - before.interval_ns;
  const auto due_in = static_cast<std::uint64_t>(std::llround(std::min(before.interval_ns, most)));
  return {static_cast<std::int64_t>(static_cast<std::uint64_t>(before.session_ns) + due_in),
          std::llround(std::min(length, most)), missing_between(before, after)};
}

void StreamLedger::open(const Packet& before, const Packet& after) {
  const std::uint64_t missing = missing_between(before, after);
  counters_.lost += missing;
  counters_.gaps += missing > 0 ? 1 : 0;
}

void StreamLedger::close(const Packet& before, const Packet& after) {
  const std::uint64_t missing = missing_between(before, after);
  counters_.lost -= missing;
  counters_.gaps -= missing > 0 ? 1 : 0;
}

Arrival StreamLedger::add(std::int64_t device_ns, double interval_ns, std::int64_t session_ns) {
  RIGCAL_ASSERT(interval_ns >= 1.0, "a packet interval of no length");
  ++counters_.received;
  const Packet packet{device_ns, session_ns, interval_ns};
  if (!open_.empty() && device_ns <= open_.back().device_ns) return add_late(packet);
  if (!open_.empty()) open(open_.back(), packet);
  open_.push_back(packet);
  if (open_.size() > kOpen) settle_oldest();
  return Arrival::in_order;
}

Arrival StreamLedger::add_late(const Packet& packet) {
  // Nearly all of them belong near the end.
  auto after = open_.end();
  while (after != open_.begin() && (after - 1)->device_ns >= packet.device_ns) --after;
  if (after->device_ns == packet.device_ns) {
    ++counters_.duplicated;
    return Arrival::duplicate;
  }
  if (after == open_.begin() && is_settled_) {
    ++counters_.too_late;
    return Arrival::late;
  }
  ++counters_.out_of_order;
  if (after != open_.begin()) {
    close(*(after - 1), *after);
    open(*(after - 1), packet);
  }
  open(packet, *after);
  open_.insert(after, packet);
  if (open_.size() > kOpen) settle_oldest();
  return Arrival::late;
}

void StreamLedger::note(const StreamGap& gap) {
  if (gap.lost == 0) return;
  if (gap.length_ns > longest_.length_ns) longest_ = gap;
  if (settled_.size() < kListedGaps) settled_.push_back(gap);
}

void StreamLedger::settle_oldest() {
  note(gap_between(open_[0], open_[1]));
  open_.pop_front();
  is_settled_ = true;
}

void StreamLedger::restart() {
  if (open_.empty()) return;
  ++counters_.restarts;
  while (open_.size() > 1) settle_oldest();
  open_.clear();
  is_settled_ = false;
}

StreamBook StreamLedger::book() const {
  StreamBook book{counters_, settled_, longest_};
  for (std::size_t i = 1; i < open_.size(); ++i) {
    const StreamGap gap = gap_between(open_[i - 1], open_[i]);
    if (gap.lost == 0) continue;
    if (gap.length_ns > book.longest_gap.length_ns) book.longest_gap = gap;
    if (book.listed_gaps.size() < kListedGaps) book.listed_gaps.push_back(gap);
  }
  return book;
}

}  // namespace rigcal
