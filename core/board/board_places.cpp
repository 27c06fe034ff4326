#include <algorithm>
#include <cmath>
#include <map>

#include "core/board/board_adjustment.h"

namespace rigcal {
namespace {

struct Fit {
  std::size_t alternative = 0;
  double distance = 0.0;
};

// The turn under which a sighting lies nearest to a board.
Fit best_turn(const BoardSighting& seen, const SE3& T_base_sensor, const SE3& T_base_board, const BoardModel& board) {
  Fit best{0, 1e9};
  for (std::size_t k = 0; k < seen.alternatives.size(); ++k) {
    const SE3 here = T_base_sensor * (seen.T_sensor_board * seen.alternatives[k]);
    const double distance = board.corner_distance(here, T_base_board);
    if (distance < best.distance) best = {k, distance};
  }
  return best;
}

}  // namespace

std::vector<BoardPlace> board_places(const std::vector<BoardSighting>& sightings,
                                     const std::vector<BoardSensor>& sensors, const BoardModel& board,
                                     const std::vector<char>& is_placed) {
  std::map<int, std::vector<const BoardSighting*>> stops;
  for (const BoardSighting& s : sightings) {
    if (is_placed.empty() || is_placed[static_cast<std::size_t>(s.sensor)] != 0) stops[s.stop].push_back(&s);
  }
  std::vector<BoardPlace> out;
  for (auto& [stop, seen] : stops) {
    // Whole boards in images know their corners' numbers best, so the others follow them.
    std::stable_sort(seen.begin(), seen.end(), [](const BoardSighting* a, const BoardSighting* b) {
      return a->alternatives.size() < b->alternatives.size() ||
             (a->alternatives.size() == b->alternatives.size() && a->corner_sigma_m < b->corner_sigma_m);
    });
    const std::size_t first = out.size();
    for (const BoardSighting* s : seen) {
      const SE3& T_base_sensor = sensors[static_cast<std::size_t>(s->sensor)].T_base_sensor;
      BoardPlace* nearest = nullptr;
      Fit fit{0, agreement_gate(*s, board)};
      for (std::size_t p = first; p < out.size(); ++p) {
        const bool has_it = std::any_of(out[p].sightings.begin(), out[p].sightings.end(),
                                        [&](const BoardSighting& other) { return other.sensor == s->sensor; });
        const Fit here = best_turn(*s, T_base_sensor, out[p].T_base_board, board);
        if (has_it || here.distance > fit.distance) continue;
        fit = here;
        nearest = &out[p];
      }
      if (nearest == nullptr) {
        nearest = &out.emplace_back();
        nearest->stop = stop;
        fit.alternative = 0;
        nearest->T_base_board = T_base_sensor * (s->T_sensor_board * s->alternatives[0]);
      }
      nearest->sightings.push_back(resolved(*s, fit.alternative, board));
    }
  }
  return out;
}

}  // namespace rigcal
