#include "core/start/own_view.h"

#include <Eigen/LU>
#include <cmath>

namespace rigcal {

SurfelIndex index_of(const PatchSurfels& patch, double reach_m) {
  std::vector<PlacedSurfel> placed;
  for (const Surfel& s : patch.surfels) placed.push_back({s.mean, s.normal, 0});
  return {without_repetitions(placed, 0.5 * reach_m), reach_m};
}

std::vector<double> balanced_weights(const std::vector<Vector3d>& normals) {
  Matrix3d sum = 1e-6 * Matrix3d::Identity();
  for (const Vector3d& n : normals) sum += n * n.transpose();
  // A direction that hardly anything faces is none.
  sum.diagonal().array() += 0.01 * sum.trace();
  const Matrix3d inverse = sum.inverse();
  std::vector<double> out;
  double total = 0.0;
  for (const Vector3d& n : normals) {
    out.push_back(n.dot(inverse * n));
    total += out.back();
  }
  for (double& w : out) w /= total;
  return out;
}

namespace {

std::vector<PlacedSurfel> placed_at(const std::vector<PatchSurfels>& patches, const std::vector<SE3>& poses) {
  std::vector<PlacedSurfel> placed;
  for (const PatchSurfels& p : patches) {
    const SE3& T = poses[static_cast<std::size_t>(p.stop)];
    for (const Surfel& s : p.surfels) placed.push_back({T * s.mean, T.R * s.normal, p.stop});
  }
  return placed;
}

double met_by_others(const std::vector<PlacedSurfel>& placed, const std::vector<double>& weights) {
  const SurfelIndex index(placed, 0.4);
  double met = 0.0;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const PlacedSurfel& s = placed[i];
    if (index.find(s.mean, s.normal, same_surface_cosine, same_surface_m, s.group) >= 0) met += weights[i];
  }
  return met;
}

}  // namespace

double agreement(const std::vector<PatchSurfels>& patches, const std::vector<SE3>& poses) {
  const std::vector<PlacedSurfel> placed = placed_at(patches, poses);
  if (placed.empty()) return 0.0;
  const auto count = static_cast<double>(placed.size());
  return met_by_others(placed, std::vector<double>(placed.size(), 1.0)) / count;
}

double balanced_agreement(const std::vector<PatchSurfels>& patches, const std::vector<SE3>& poses) {
  const std::vector<PlacedSurfel> placed = placed_at(patches, poses);
  std::vector<Vector3d> normals;
  for (const PlacedSurfel& s : placed) normals.push_back(s.normal);
  return met_by_others(placed, balanced_weights(normals));
}

}  // namespace rigcal
