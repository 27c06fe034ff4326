#include "apps/experiment/speed/used_memory.h"

#include <algorithm>
#include <fstream>
#include <string>

#include "apps/common/kept_memory.h"

namespace rigcal::speed {
namespace {

// A line of /proc/self/status, in 10^6 bytes.
std::optional<double> status_mb(const std::string& name) {
  std::ifstream status("/proc/self/status");
  std::string key;
  while (status >> key) {
    if (key != name + ":") {
      std::getline(status, key);
      continue;
    }
    double kib = 0.0;
    if (status >> kib) return kib * 1024.0 / 1e6;
  }
  return std::nullopt;
}

}  // namespace

MemoryWatch::MemoryWatch() {
  give_back_freed_memory();
  std::ofstream forget("/proc/self/clear_refs");
  forget << "5";
  forget.close();
  if (forget) before_mb_ = status_mb("VmRSS");
}

double MemoryWatch::peak_mb() const {
  const std::optional<double> peak = status_mb("VmHWM");
  return before_mb_ && peak ? std::max(0.0, *peak - *before_mb_) : 0.0;
}

}  // namespace rigcal::speed
