#include "core/clocks/stream_ledger.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace rigcal {
namespace {

// The public driver's rule for these sensors: less is jitter of the stamps, more is a packet that is missing.
constexpr double kGapIntervals = 1.8;

}  // namespace

Arrival StreamLedger::add(std::int64_t device_ns, double interval_ns, std::int64_t session_ns) {
  RIGCAL_ASSERT(interval_ns >= 1.0, "a packet interval of no length");
  ++counters_.received;
  if (started_ && device_ns <= last_ns_) {
    if (is_known(device_ns)) {
      ++counters_.duplicated;
      return Arrival::duplicate;
    }
    ++counters_.out_of_order;
    fill_gap(device_ns);
    remember(device_ns);
    return Arrival::late;
  }
  if (started_ && static_cast<double>(device_ns) - static_cast<double>(last_ns_) > kGapIntervals * interval_ns_) {
    open_gap(device_ns, session_ns);
  }
  started_ = true;
  last_ns_ = device_ns;
  interval_ns_ = interval_ns;
  remember(device_ns);
  return Arrival::in_order;
}

void StreamLedger::restart() {
  if (started_) ++counters_.restarts;
  started_ = false;
  recent_count_ = 0;
  open_count_ = 0;
}

bool StreamLedger::is_known(std::int64_t device_ns) const {
  const auto end = recent_.begin() + static_cast<std::ptrdiff_t>(std::min(recent_count_, kRemembered));
  return std::find(recent_.begin(), end, device_ns) != end;
}

void StreamLedger::remember(std::int64_t device_ns) { recent_[recent_count_++ % kRemembered] = device_ns; }

void StreamLedger::open_gap(std::int64_t device_ns, std::int64_t session_ns) {
  const double length = static_cast<double>(device_ns) - static_cast<double>(last_ns_);
  const auto missing = static_cast<std::uint64_t>(std::llround(length / interval_ns_) - 1);
  ++counters_.gaps;
  counters_.lost += missing;
  OpenGap& gap = open_[open_count_++ % kOpenGaps];
  gap = {last_ns_, device_ns, missing, kListedGaps};
  if (listed_.size() < kListedGaps) {
    gap.listed = listed_.size();
    listed_.push_back({session_ns, device_ns - last_ns_, missing});
  }
}

void StreamLedger::fill_gap(std::int64_t device_ns) {
  const std::size_t count = std::min(open_count_, kOpenGaps);
  for (std::size_t i = 0; i < count; ++i) {
    OpenGap& gap = open_[i];
    if (device_ns <= gap.from || device_ns >= gap.to || gap.missing == 0) continue;
    --gap.missing;
    --counters_.lost;
    if (gap.missing == 0) --counters_.gaps;
    if (gap.listed < kListedGaps) --listed_[gap.listed].lost;
    return;
  }
}

std::vector<StreamGap> StreamLedger::gaps() const {
  std::vector<StreamGap> gaps;
  std::copy_if(listed_.begin(), listed_.end(), std::back_inserter(gaps),
               [](const StreamGap& gap) { return gap.lost > 0; });
  return gaps;
}

}  // namespace rigcal
