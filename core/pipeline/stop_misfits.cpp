#include "core/pipeline/stop_misfits.h"

#include "core/base/median.h"
#include "core/pipeline/used_shares.h"

namespace rigcal {
namespace {

constexpr std::size_t least_stops = 4;
constexpr double least_of_usual = 0.4;

}  // namespace

std::vector<std::size_t> misfit_stops(int stops, const std::vector<PatchCells>& patches, const std::vector<char>& use,
                                      const PlaneMap& map) {
  std::vector<UsedPoints> by_stop(static_cast<std::size_t>(stops));
  for (const auto& [place, points] : used_points(patches, use, map))
    by_stop[static_cast<std::size_t>(place.second)] += points;
  std::vector<double> shares;
  for (const UsedPoints& points : by_stop) {
    if (points.seen > 0.0) shares.push_back(points.share());
  }
  if (shares.size() < least_stops) return {};
  const double least = least_of_usual * median(std::move(shares));
  std::vector<std::size_t> misfits;
  for (std::size_t j = 0; j < by_stop.size(); ++j) {
    if (by_stop[j].seen > 0.0 && by_stop[j].share() < least) misfits.push_back(j);
  }
  return misfits;
}

}  // namespace rigcal
