#include "apps/recording/stamp_guess.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "core/base/seconds.h"

namespace rigcal {
namespace {

constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max() / 4;
constexpr std::size_t most_stamps = 200;  ///< That are looked at; more of them tell no more.

/// Offsets that put a stamp into a stop, or all stamps into stops.
struct Offsets {
  std::int64_t from_ns = 0;
  std::int64_t to_ns = 0;
};

/// Stops and the turns between them.
bool is_within_run(std::int64_t stamp_ns, const std::vector<Stop>& stops) {
  return stamp_ns >= stops.front().start_ns && stamp_ns <= stops.back().end_ns;
}

std::string guess_of_unit(const std::vector<std::int64_t>& stamps, const std::vector<Stop>& stops) {
  constexpr std::array<std::pair<std::int64_t, const char*>, 3> units{
      {{1000, "microseconds"}, {1'000'000, "milliseconds"}, {ns_per_second, "seconds"}}};
  for (const auto& [factor, name] : units) {
    const bool fits = std::all_of(stamps.begin(), stamps.end(), [&, factor = factor](std::int64_t stamp) {
      // A stamp in whole seconds may be up to one too early.
      return stamp <= largest / factor &&
             (is_within_run(stamp * factor, stops) || is_within_run(stamp * factor + factor - 1, stops));
    });
    if (fits) return std::string("their stamps look like ") + name + ": write nanoseconds";
  }
  return {};
}

/// All offsets that put every stamp into a stop.
std::vector<Offsets> common_offsets(const std::vector<std::int64_t>& stamps, const std::vector<Stop>& stops) {
  std::vector<std::pair<std::int64_t, int>> edges;  // where so many stamps more lie in a stop
  for (const std::int64_t stamp : stamps) {
    for (const Stop& stop : stops) {
      edges.emplace_back(stop.start_ns - stamp, -1);  // begins before another one ends at the same offset
      edges.emplace_back(stop.end_ns - stamp, 1);
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<Offsets> common;
  int inside = 0;
  for (const auto& [offset, step] : edges) {
    const bool had_all = inside == static_cast<int>(stamps.size());
    inside -= step;
    if (inside == static_cast<int>(stamps.size())) common.push_back({offset, offset});
    if (had_all) common.back().to_ns = offset;
  }
  return common;
}

/// One by which clocks are usually off, if it is among them: time zones, and the leap seconds of GPS and TAI.
std::optional<std::int64_t> usual_offset(const Offsets& offsets) {
  constexpr std::int64_t half_hour_ns = 1800 * ns_per_second;
  constexpr std::int64_t most_half_hours = 28;
  const auto half_hours =
      static_cast<std::int64_t>(std::ceil(static_cast<double>(offsets.from_ns) / static_cast<double>(half_hour_ns)));
  if (std::abs(half_hours) <= most_half_hours && half_hours != 0 && half_hours * half_hour_ns <= offsets.to_ns)
    return half_hours * half_hour_ns;
  for (const std::int64_t seconds : {18, -18, 37, -37}) {
    if (seconds * ns_per_second >= offsets.from_ns && seconds * ns_per_second <= offsets.to_ns)
      return seconds * ns_per_second;
  }
  return std::nullopt;
}

std::string seconds(std::int64_t ns) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f s", seconds_of_ns(ns));
  return text;
}

/// In how many stops the stamps would lie.
std::size_t stops_with(std::int64_t offset_ns, const std::vector<std::int64_t>& stamps,
                       const std::vector<Stop>& stops) {
  std::set<int> used;
  for (const std::int64_t stamp : stamps) {
    for (const Stop& stop : stops) {
      if (stamp + offset_ns >= stop.start_ns && stamp + offset_ns <= stop.end_ns) used.insert(stop.index);
    }
  }
  return used.size();
}

/// Some offset always puts one image into a stop, and often two; three stops are no accident.
std::optional<std::int64_t> offset_of(const std::vector<std::int64_t>& stamps, const std::vector<Stop>& stops) {
  constexpr std::size_t enough_stops = 3;
  std::optional<std::int64_t> least;
  for (const Offsets& offsets : common_offsets(stamps, stops)) {
    if (const std::optional<std::int64_t> usual = usual_offset(offsets)) return usual;
    const std::int64_t middle = offsets.from_ns + (offsets.to_ns - offsets.from_ns) / 2;
    if (!least || std::abs(middle) < std::abs(*least)) least = middle;
  }
  if (!least || stops_with(*least, stamps, stops) < enough_stops) return std::nullopt;
  return least;
}

}  // namespace

std::string nearest_stop(const std::vector<Stop>& stops, std::int64_t stamp_ns) {
  std::string text;
  std::int64_t least = -1;
  for (const Stop& stop : stops) {
    const bool before = stamp_ns < stop.start_ns;
    const std::int64_t gap = before ? stop.start_ns - stamp_ns : std::max<std::int64_t>(0, stamp_ns - stop.end_ns);
    if (least >= 0 && gap >= least) continue;
    least = gap;
    text = seconds(gap) + (before ? " before stop " : " after stop ") + std::to_string(stop.index);
    if (gap == 0) text = "its exposure does not end in stop " + std::to_string(stop.index);
  }
  return text;
}

std::string guess_of_stamps(const std::vector<std::int64_t>& stamps_ns, const std::vector<Stop>& stops) {
  if (stamps_ns.empty() || stops.empty()) return {};
  std::vector<std::int64_t> some;
  const std::size_t step = (stamps_ns.size() + most_stamps - 1) / most_stamps;
  for (std::size_t k = 0; k < stamps_ns.size(); k += step) some.push_back(std::min(stamps_ns[k], largest));
  if (const std::string unit = guess_of_unit(some, stops); !unit.empty()) return unit;
  const std::optional<std::int64_t> offset = offset_of(some, stops);
  if (!offset) return {};
  char text[160];
  std::snprintf(text, sizeof text,
                "with %.3f s added to their stamps all would lie in stops (another time zone or clock?): correct the "
                "stamps, nothing was shifted",
                seconds_of_ns(*offset));
  return text;
}

}  // namespace rigcal
