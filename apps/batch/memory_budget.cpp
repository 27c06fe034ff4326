#include "apps/batch/memory_budget.h"

#include <algorithm>
#include <fstream>
#include <string>

namespace rigcal::batch {
namespace {

constexpr std::uint64_t unknown_peak = std::uint64_t{2} << 30U;

std::uint64_t machine_available() {
  std::ifstream in("/proc/meminfo");
  for (std::string name; in >> name;) {
    std::uint64_t kib = 0;
    if (name == "MemAvailable:" && in >> kib) return kib * 1024U;
    std::getline(in, name);
  }
  return 0;
}

std::uint64_t number_in(const std::string& path) {
  std::ifstream in(path);
  std::uint64_t value = 0;
  return in >> value ? value : 0;  // "max": no limit.
}

// Of version 2, whose line in /proc/self/cgroup begins with "0::".
std::uint64_t group_left() {
  std::ifstream in("/proc/self/cgroup");
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("0::", 0) != 0) continue;
    const std::string folder = "/sys/fs/cgroup" + line.substr(3);
    const std::uint64_t limit = number_in(folder + "/memory.max");
    if (limit > 0) return limit - std::min(limit, number_in(folder + "/memory.current"));
  }
  return 0;
}

}  // namespace

std::uint64_t available_memory() {
  const std::uint64_t machine = machine_available();
  const std::uint64_t group = group_left();
  return group > 0 && (machine == 0 || group < machine) ? group : machine;
}

void MemoryBudget::saw_peak(double megabytes) {
  largest_ = std::max(largest_, static_cast<std::uint64_t>(megabytes * 1048576.0));
}

bool MemoryBudget::fits(int running) const {
  const std::uint64_t each = largest_ > 0 ? largest_ : unknown_peak;
  return running == 0 || (static_cast<std::uint64_t>(running) + 1U) * each <= bytes_;
}

}  // namespace rigcal::batch
