#include "core/quality/shared_surfaces.h"

#include <cmath>
#include <map>
#include <utility>

#include "core/planes/plane_factor.h"

namespace rigcal {
namespace {

// What one LiDAR saw of a plane in all stops, in the world.
struct Mean {
  Vector3d before = Vector3d::Zero();
  Vector3d after = Vector3d::Zero();
  double information = 0.0;  ///< 1 / variance of its offset.
};

struct Sums {
  std::size_t surfaces = 0;
  double weight = 0.0;
  double before = 0.0;
  double after = 0.0;

  void add(double w, double offset_before, double offset_after) {
    ++surfaces;
    weight += w;
    before += w * offset_before * offset_before;
    after += w * offset_after * offset_after;
  }
  [[nodiscard]] SharedSurfaces named(std::string first, std::string second) const {
    return {std::move(first), std::move(second), surfaces, std::sqrt(before / weight), std::sqrt(after / weight)};
  }
};

std::map<int, Mean> means_of(const PlaneFeature& feature, const RigState& before, const RigState& after) {
  std::map<int, Mean> means;
  for (const PlaneObservation& o : feature.observations) {
    if (!(o.offset_variance > 0.0)) continue;
    const double information = 1.0 / o.offset_variance;
    Mean& mean = means[o.lidar];
    mean.before += information * (before.T_G_sensor(o.stop, o.lidar) * o.mean);
    mean.after += information * (after.T_G_sensor(o.stop, o.lidar) * o.mean);
    mean.information += information;
  }
  for (auto& [lidar, mean] : means) {
    mean.before /= mean.information;
    mean.after /= mean.information;
  }
  return means;
}

}  // namespace

Vector3d plane_normal(const PlaneFeature& feature, const RigState& state) {
  PlaneDerivatives plane;
  plane_derivatives(feature, state, HessianForm::gauss_newton, plane);
  return plane.normal;
}

std::vector<SharedSurfaces> shared_surfaces(const std::vector<PlaneFeature>& features, const RigState& before,
                                            const RigState& after, const std::vector<std::string>& names) {
  std::map<std::pair<int, int>, Sums> pairs;
  Sums all;
  for (const PlaneFeature& feature : features) {
    if (feature.merged) continue;
    const std::map<int, Mean> means = means_of(feature, before, after);
    if (means.size() < 2) continue;
    const Vector3d normal = plane_normal(feature, after);
    for (auto a = means.begin(); a != means.end(); ++a) {
      for (auto b = std::next(a); b != means.end(); ++b) {
        const double weight = 1.0 / (1.0 / a->second.information + 1.0 / b->second.information);
        const double offset_before = normal.dot(a->second.before - b->second.before);
        const double offset_after = normal.dot(a->second.after - b->second.after);
        pairs[{a->first, b->first}].add(weight, offset_before, offset_after);
        all.add(weight, offset_before, offset_after);
      }
    }
  }
  std::vector<SharedSurfaces> out;
  for (const auto& [pair, sums] : pairs) {
    out.push_back(
        sums.named(names[static_cast<std::size_t>(pair.first)], names[static_cast<std::size_t>(pair.second)]));
  }
  if (all.surfaces > 0) out.push_back(all.named({}, {}));
  return out;
}

}  // namespace rigcal
