#include "core/pipeline/stop_misfits.h"

#include "core/base/median.h"

namespace rigcal {
namespace {

constexpr std::size_t least_stops = 4;
constexpr double least_of_usual = 0.4;

}  // namespace

std::vector<std::size_t> misfit_stops(int stops, const std::vector<PatchCells>& patches, const std::vector<char>& use,
                                      const PlaneMap& map) {
  std::vector<double> points(static_cast<std::size_t>(stops), 0.0);
  std::vector<double> on_planes(static_cast<std::size_t>(stops), 0.0);
  for (std::size_t k = 0; k < patches.size(); ++k) {
    if (!use[k]) continue;
    for (const Cell& cell : patches[k].cells) points[static_cast<std::size_t>(patches[k].stop)] += cell.N;
  }
  for (const PlaneFeature& feature : map.features) {
    if (feature.merged) continue;
    for (const PlaneObservation& o : feature.observations) on_planes[static_cast<std::size_t>(o.stop)] += o.N;
  }
  std::vector<double> shares;
  for (std::size_t j = 0; j < points.size(); ++j) {
    if (points[j] > 0.0) shares.push_back(on_planes[j] / points[j]);
  }
  if (shares.size() < least_stops) return {};
  const double least = least_of_usual * median(std::move(shares));
  std::vector<std::size_t> misfits;
  for (std::size_t j = 0; j < points.size(); ++j) {
    if (points[j] > 0.0 && on_planes[j] / points[j] < least) misfits.push_back(j);
  }
  return misfits;
}

}  // namespace rigcal
