#pragma once

#include <string>
#include <vector>

#include "core/base/seconds.h"
#include "core/quality/result.h"

namespace rigcal {

/// Largest resident memory of this process so far, in megabytes (1e6 bytes).
[[nodiscard]] double peak_memory_mb();

/// Collects what report.json tells about each stage.
class StageClock {
 public:
  /// Begins a stage; the one before it ends.
  StageReport& begin(const std::string& name);
  void end();
  [[nodiscard]] std::vector<StageReport> take();

 private:
  std::vector<StageReport> stages_;
  SteadyClock::time_point start_;
  bool open_ = false;
};

}  // namespace rigcal
