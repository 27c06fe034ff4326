#pragma once

#include <cstdint>

namespace rigcal::batch {

/// Bytes that this process may still take: what the machine has available, or, where that is less, what its control
/// group (a container, a job of a scheduler) has left. 0: not known.
[[nodiscard]] std::uint64_t available_memory();

/// How many calibrations fit: each counts for the largest peak seen so far, before the first has ended for 2 GiB. One
/// always fits.
class MemoryBudget {
 public:
  explicit MemoryBudget(std::uint64_t bytes) : bytes_(bytes) {}
  void saw_peak(double megabytes);
  [[nodiscard]] bool fits(int running) const;

 private:
  std::uint64_t bytes_;
  std::uint64_t largest_ = 0;
};

}  // namespace rigcal::batch
