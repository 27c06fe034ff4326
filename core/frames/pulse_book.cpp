#include "core/frames/pulse_book.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/clocks/stamps.h"

namespace rigcal {
namespace {

constexpr double reach_sigmas = 6.0;
constexpr double least_reach_ns = 1e6;
constexpr double separation_sigmas = 5.0;

}  // namespace

void PulseBook::add(const TriggerPulse& pulse) {
  RIGCAL_ASSERT(!is_full(), "a pulse for a book that is full");
  entries_[(first_ + size_) % kCapacity] = {pulse, false};
  ++size_;
}

void PulseBook::drop_first() {
  RIGCAL_ASSERT(size_ > 0, "no pulse in the book");
  first_ = (first_ + 1) % kCapacity;
  --size_;
}

std::size_t PulseBook::first_from(std::int64_t stamp_ns) const {
  std::size_t low = 0;
  std::size_t high = size_;
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (pulse(middle).stamp_ns < stamp_ns) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

double PulseBook::reach_ns(const StampEstimate& estimate) {
  return std::max(reach_sigmas * estimate.error_ns, least_reach_ns);
}

PulseChoice PulseBook::choose(const StampEstimate& estimate) const {
  const std::size_t after = first_from(estimate.stamp_ns);
  double nearest = std::numeric_limits<double>::infinity();
  double second = nearest;
  PulseChoice choice;
  // The two on either side are enough: the second nearest may be on the side of the nearest.
  for (std::size_t i = after < 2 ? 0 : after - 2; i < std::min(size_, after + 2); ++i) {
    const double off = std::abs(static_cast<double>(stamp_difference(pulse(i).stamp_ns, estimate.stamp_ns)));
    if (off < nearest) {
      second = nearest;
      nearest = off;
      choice.index = i;
    } else {
      second = std::min(second, off);
    }
  }
  if (nearest > reach_ns(estimate)) return choice;
  const double clear = separation_sigmas * estimate.error_ns;
  choice.verdict = second * second - nearest * nearest >= clear * clear ? PulseChoice::Verdict::clear
                                                                        : PulseChoice::Verdict::several;
  return choice;
}

}  // namespace rigcal
