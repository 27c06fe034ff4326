#include "core/pipeline/used_shares.h"

#include <iterator>

namespace rigcal {
namespace {

constexpr std::size_t least_stops = 4;

UsedShare share_of(const std::map<int, UsedPoints>& by_stop) {
  UsedPoints earlier;
  UsedPoints later;
  const auto middle = std::next(by_stop.begin(), static_cast<std::ptrdiff_t>((by_stop.size() + 1) / 2));
  for (auto at = by_stop.begin(); at != middle; ++at) earlier += at->second;
  for (auto at = middle; at != by_stop.end(); ++at) later += at->second;
  UsedPoints all = earlier;
  all += later;
  if (by_stop.size() < least_stops) return {all.share(), {all.share(), all.share(), 0}};
  return {all.share(), {earlier.share(), later.share(), middle->first}};
}

}  // namespace

std::map<std::pair<int, int>, UsedPoints> used_points(const std::vector<PatchCells>& patches,
                                                      const std::vector<char>& use, const PlaneMap& map) {
  std::map<std::pair<int, int>, UsedPoints> out;
  for (std::size_t k = 0; k < patches.size(); ++k) {
    if (!use[k]) continue;
    UsedPoints& points = out[{patches[k].lidar, patches[k].stop}];
    for (const Cell& cell : patches[k].cells) points.seen += cell.N;
  }
  for (const PlaneFeature& feature : map.features) {
    if (feature.merged) continue;
    for (const PlaneObservation& o : feature.observations) out[{o.lidar, o.stop}].used += o.N;
  }
  return out;
}

std::vector<UsedShare> used_shares(const LidarRecording& recording, const LidarSolution& solution) {
  std::vector<std::map<int, UsedPoints>> by_stop(recording.lidar_sensors.size());
  for (const auto& [place, points] : used_points(recording.patches, solution.use, solution.refined.map))
    by_stop[static_cast<std::size_t>(place.first)][place.second] = points;
  std::vector<UsedShare> out;
  for (const std::map<int, UsedPoints>& points : by_stop) out.push_back(share_of(points));
  return out;
}

}  // namespace rigcal
