#include "apps/batch/memory_budget.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

namespace rigcal::batch {
namespace {

constexpr std::uint64_t unknown_peak = std::uint64_t{2} << 30U;

// What a group of the first version has for "no limit" is rounded to pages; no machine has as much.
constexpr std::uint64_t no_limit = std::uint64_t{1} << 60U;

namespace fs = std::filesystem;

// What the files of a group are called, by version.
struct GroupFiles {
  const char* limit;
  const char* use;
  const char* forgettable;  // The key in memory.stat of what is only remembered of files, in the groups below, too.
};
constexpr GroupFiles files_of_v1{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"};
constexpr GroupFiles files_of_v2{"memory.max", "memory.current", "inactive_file"};

// The number behind a name in a file of lines like "name 123".
std::optional<std::uint64_t> named_number(const fs::path& path, const std::string& name) {
  std::ifstream in(path);
  for (std::string found; in >> found;) {
    std::uint64_t value = 0;
    if (found == name) return in >> value ? std::optional(value) : std::nullopt;
    std::getline(in, found);
  }
  return std::nullopt;
}

// Nothing where it is none: "max" is no limit.
std::optional<std::uint64_t> number_in(const fs::path& path) {
  std::ifstream in(path);
  std::uint64_t value = 0;
  return in >> value ? std::optional(value) : std::nullopt;
}

std::optional<std::uint64_t> lesser(std::optional<std::uint64_t> a, std::optional<std::uint64_t> b) {
  if (!a || !b) return a ? a : b;
  return std::min(*a, *b);
}

std::optional<std::uint64_t> left_in_group(const fs::path& folder, const GroupFiles& files) {
  const std::optional<std::uint64_t> limit = number_in(folder / files.limit);
  if (!limit || *limit >= no_limit) return std::nullopt;
  const std::uint64_t use = number_in(folder / files.use).value_or(0);
  const std::uint64_t forgettable = named_number(folder / "memory.stat", files.forgettable).value_or(0);
  return *limit - std::min(*limit, use - std::min(use, forgettable));
}

// A limit anywhere above holds as well. In a container, `group` may be told as it is seen from outside, and not be
// there: its own limit is then at the root.
std::optional<std::uint64_t> left_up_to(const fs::path& root, const std::string& group, const GroupFiles& files) {
  std::optional<std::uint64_t> left = left_in_group(root, files);
  fs::path folder = root;
  for (const fs::path& name : fs::path(group).relative_path()) {
    if (name == "..") break;  // Outside of what can be seen from here.
    folder /= name;
    left = lesser(left, left_in_group(folder, files));
  }
  return left;
}

// A line for each hierarchy, "number:controllers:group"; that of the second version has no controllers.
std::optional<std::uint64_t> groups_left(const std::string& proc, const std::string& groups) {
  std::optional<std::uint64_t> left;
  std::ifstream in(fs::path(proc) / "self/cgroup");
  for (std::string line; std::getline(in, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const std::string group = line.substr(second + 1);
    if (controllers == ",,") left = lesser(left, left_up_to(groups, group, files_of_v2));
    if (controllers.find(",memory,") != std::string::npos)
      left = lesser(left, left_up_to(fs::path(groups) / "memory", group, files_of_v1));
  }
  return left;
}

}  // namespace

std::optional<std::uint64_t> available_memory(const std::string& proc, const std::string& groups) {
  std::optional<std::uint64_t> machine = named_number(fs::path(proc) / "meminfo", "MemAvailable:");
  if (machine) *machine *= 1024U;
  return lesser(machine, groups_left(proc, groups));
}

void MemoryBudget::saw_peak(double megabytes) {
  largest_ = std::max(largest_, static_cast<std::uint64_t>(megabytes * 1048576.0));
}

bool MemoryBudget::fits(int running) const {
  const std::uint64_t each = largest_ > 0 ? largest_ : unknown_peak;
  return running == 0 || (static_cast<std::uint64_t>(running) + 1U) * each <= bytes_;
}

}  // namespace rigcal::batch
