#include "core/pipeline/board_losses.h"

#include <algorithm>
#include <map>

namespace rigcal {
namespace {

constexpr std::size_t least_together = 3;

bool saw(std::span<const BoardSighting> sightings, int sensor, int stop) {
  return std::any_of(sightings.begin(), sightings.end(),
                     [&](const BoardSighting& b) { return b.sensor == sensor && b.stop == stop; });
}

}  // namespace

BoardLosses lost_boards(int sensor, int via, std::span<const BoardSighting> seen, std::span<const BoardPlace> places) {
  std::map<int, bool> goes;  // By stop.
  for (const BoardSighting& b : seen) {
    if (b.sensor == sensor && saw(seen, via, b.stop)) goes[b.stop] = false;
  }
  for (const BoardPlace& place : places) {
    const bool holds = place.why_out.empty() && place.sightings.size() > 1 && saw(place.sightings, sensor, place.stop);
    if (const auto stop = goes.find(place.stop); stop != goes.end() && holds) stop->second = true;
  }
  BoardLosses out;
  std::size_t on_end = 0;
  std::size_t longest = 0;
  for (const auto& [stop, is_held] : goes) {
    on_end = is_held ? 0 : on_end + 1;
    longest = std::max(longest, on_end);
    if (!is_held) out.stops.push_back(stop);
  }
  out.together = out.stops.size() >= least_together && longest == out.stops.size();
  return out;
}

}  // namespace rigcal
