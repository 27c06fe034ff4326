#pragma once

#include <optional>

namespace rigcal::speed {

/// How much more memory this process held at most than at the start of the watch, where the kernel tells.
class MemoryWatch {
 public:
  /// Gives back what is free and forgets the peak so far.
  MemoryWatch();
  /// 10^6 bytes; 0 where the kernel does not tell.
  [[nodiscard]] double peak_mb() const;

 private:
  std::optional<double> before_mb_;
};

}  // namespace rigcal::speed
