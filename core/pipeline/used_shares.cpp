#include "core/pipeline/used_shares.h"

#include <iterator>
#include <map>

namespace rigcal {
namespace {

constexpr std::size_t least_stops = 4;

struct Points {
  double seen = 0.0;
  double used = 0.0;

  Points& operator+=(const Points& other) {
    seen += other.seen;
    used += other.used;
    return *this;
  }
  [[nodiscard]] double share() const { return seen > 0.0 ? used / seen : 0.0; }
};

UsedShare share_of(const std::map<int, Points>& by_stop) {
  UsedShare out;
  Points earlier;
  Points later;
  const auto middle = std::next(by_stop.begin(), static_cast<std::ptrdiff_t>((by_stop.size() + 1) / 2));
  for (auto at = by_stop.begin(); at != middle; ++at) earlier += at->second;
  for (auto at = middle; at != by_stop.end(); ++at) later += at->second;
  Points all = earlier;
  all += later;
  out.all = out.earlier = out.later = all.share();
  if (by_stop.size() < least_stops) return out;
  out.earlier = earlier.share();
  out.later = later.share();
  out.first_later_stop = middle->first;
  return out;
}

}  // namespace

std::vector<UsedShare> used_shares(const LidarRecording& recording, const LidarSolution& solution) {
  std::vector<std::map<int, Points>> by_stop(recording.lidar_sensors.size());
  for (std::size_t k = 0; k < recording.patches.size(); ++k) {
    if (!solution.use[k]) continue;
    const PatchCells& patch = recording.patches[k];
    Points& points = by_stop[static_cast<std::size_t>(patch.lidar)][patch.stop];
    for (const Cell& cell : patch.cells) points.seen += cell.N;
  }
  for (const PlaneFeature& feature : solution.refined.map.features) {
    if (feature.merged) continue;
    for (const PlaneObservation& o : feature.observations)
      by_stop[static_cast<std::size_t>(o.lidar)][o.stop].used += o.N;
  }
  std::vector<UsedShare> out;
  for (const std::map<int, Points>& points : by_stop) out.push_back(share_of(points));
  return out;
}

}  // namespace rigcal
