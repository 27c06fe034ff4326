#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace rigcal::batch {

/// Bytes that this process may still take: what the machine has available, or, where that is less, what the control
/// groups that it is in (a container, a job of a scheduler, the steps of one) have left, of either version. Files that
/// the system only remembers are no use of memory: it lets go of them. Nothing: not known. The folders are those of the
/// system; tests have their own.
[[nodiscard]] std::optional<std::uint64_t> available_memory(const std::string& proc = "/proc",
                                                            const std::string& groups = "/sys/fs/cgroup");

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
