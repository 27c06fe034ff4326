#include "core/board/board_halves.h"

#include <algorithm>

#include "core/geometry/matrix6.h"

namespace rigcal {
namespace {

constexpr std::size_t least_boards = 4;  // of each half, that hold a sensor

struct Half {
  BoardAdjustment found;
  std::vector<std::size_t> boards;  ///< That each sensor saw.

  [[nodiscard]] bool tells(std::size_t s) const {
    return boards[s] >= least_boards && found.observable[s] != 0 && found.converged;
  }
};

Half adjust_half(const BoardAdjustment& all, std::vector<BoardPlace> places, const BoardModel& board,
                 BoardAdjustOptions options) {
  options.noise_passes = 0;
  options.drop_outliers = false;
  options.refine_intrinsics = false;
  Half out;
  out.boards.assign(all.sensors.size(), 0);
  for (const BoardPlace& place : places) {
    for (const BoardSighting& seen : place.sightings) ++out.boards[static_cast<std::size_t>(seen.sensor)];
  }
  out.found = adjust_boards(all.sensors, std::move(places), board, options);
  return out;
}

}  // namespace

std::vector<BoardHalves> compare_board_halves(const BoardAdjustment& found, const BoardModel& board,
                                              const BoardAdjustOptions& options) {
  std::vector<BoardHalves> out(found.sensors.size());
  std::vector<BoardPlace> places;
  for (const BoardPlace& place : found.places) {
    if (place.why_out.empty() && place.sightings.size() > 1) places.push_back(place);
  }
  if (places.size() < 2 * least_boards) return out;
  std::stable_sort(places.begin(), places.end(),
                   [](const BoardPlace& a, const BoardPlace& b) { return a.stop < b.stop; });
  const auto middle = places.begin() + static_cast<std::ptrdiff_t>((places.size() + 1) / 2);
  const Half earlier = adjust_half(found, {places.begin(), middle}, board, options);
  const Half later = adjust_half(found, {middle, places.end()}, board, options);
  for (std::size_t s = 0; s < out.size(); ++s) {
    if (found.sensors[s].fixed || !earlier.tells(s) || !later.tells(s)) continue;
    const SE3& T = earlier.found.sensors[s].T_base_sensor;
    const Vector6d apart = (T.inverse() * later.found.sensors[s].T_base_sensor).log();
    const Matrix6d covariance = earlier.found.covariances[s] + later.found.covariances[s];
    out[s].compared = true;
    out[s].first_later_stop = middle->stop;
    out[s].chi2 = apart.dot(solve_symmetric6(covariance, apart));
    out[s].rotation_rad = apart.head<3>().norm();
    out[s].translation_m = apart.tail<3>().norm();
  }
  return out;
}

}  // namespace rigcal
