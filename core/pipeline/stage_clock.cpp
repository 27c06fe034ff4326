#include "core/pipeline/stage_clock.h"

#include <sys/resource.h>

#include "core/base/seconds.h"

namespace rigcal {

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024.0 / 1e6;  // Linux counts in KiB
}

StageReport& StageClock::begin(const std::string& name) {
  end();
  open_ = true;
  start_ = SteadyClock::now();
  stages_.push_back({});
  stages_.back().name = name;
  return stages_.back();
}

void StageClock::end() {
  if (!open_) return;
  open_ = false;
  stages_.back().wall_s = seconds_since(start_);
  stages_.back().peak_memory_mb = peak_memory_mb();
}

std::vector<StageReport> StageClock::take() {
  end();
  return std::move(stages_);
}

}  // namespace rigcal
