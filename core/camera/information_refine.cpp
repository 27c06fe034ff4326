#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/camera/information.h"
#include "core/camera/information_cost.h"
#include "core/camera/information_images.h"
#include "core/camera/minimize_pose.h"
#include "core/geometry/matrix6.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

constexpr std::size_t max_sightings = 150'000;
// and so many while images are still made smaller.
constexpr std::size_t coarse_sightings = 40'000;
constexpr std::size_t occluding_samples = 500'000;
constexpr std::size_t coarse_occluding_samples = 250'000;
constexpr int silhouette_cells = 2;
constexpr double margin_px = 8.0;

// What is seen is asked anew after a move by so much.
constexpr double moved_rad = to_rad(0.1);
constexpr double moved_m = 0.02;

// Farther from the start it has run away.
constexpr double lost_rad = to_rad(4.0);
constexpr double lost_m = 0.6;

// Where the two tell less of each other, nothing is known of the pose either, however still the cost lies.
constexpr double least_information = 0.004;

// Differences for the curvature, in units of the root mean square change of the grey value: wide enough to look over
// the ripples that pixels and samples make.
constexpr double curvature_step = 0.7;

// The errors that no part of the images tells of, as all parts share them: edges of the map are blunt, and reflectivity
// and grey value do not change at the very same place.
constexpr double shared_error_rad = to_rad(0.02);
constexpr double shared_error_m = 0.005;

bool has_moved(const SE3& from, const SE3& to, double rad, double m) {
  return rotation_distance(from.R, to.R) > rad || (from.t - to.t).norm() > m;
}

// Evenly about `wanted` of them.
std::vector<Sighting> some_of(const std::vector<Sighting>& sightings, std::size_t wanted) {
  const std::size_t stride = std::max<std::size_t>(1, sightings.size() / wanted);
  std::vector<Sighting> some;
  for (std::size_t k = 0; k < sightings.size(); k += stride) some.push_back(sightings[k]);
  return some;
}

// Curvature of the cost at its minimum by differences of the gradient; directions in which it is flat get the least
// curvature that still is one.
Matrix6d curvature(const InformationCost& cost, const SE3& T, const Matrix6d& shape) {
  const Eigen::LLT<Matrix6d> llt(shape);
  Matrix6d H;  // in z = L^T xi
  for (int k = 0; k < 6; ++k) {
    const Vector6d step = llt.matrixU().solve(curvature_step * Vector6d::Unit(k));
    const Vector6d change =
        cost.derivatives(T * SE3::exp(step)).gradient - cost.derivatives(T * SE3::exp(-step)).gradient;
    H.col(k) = llt.matrixL().solve(change) / (2.0 * curvature_step);
  }
  const SymmetricEigen6 eigen = symmetric_eigen6(0.5 * (H + H.transpose()));
  const double least = 0.05 * std::max(eigen.values.maxCoeff(), 1e-9);
  const Vector6d values = eigen.values.cwiseMax(least);
  const Matrix6d in_z = eigen.vectors * values.asDiagonal() * eigen.vectors.transpose();
  const Matrix6d L = llt.matrixL();
  return L * in_z * L.transpose();
}

// Some of the sightings tell the curvature, a mean over all; how far their gradient scatters all must tell.
Matrix6d covariance_at(const InformationCost& cost, const InformationCost& of_some, const SE3& T) {
  Matrix6d shape = of_some.derivatives(T).shape;
  shape.diagonal().array() += 1e-9 * shape.trace() + 1e-12;
  const Matrix6d inverse = inverse6(curvature(of_some, T, shape));
  Matrix6d covariance = inverse * cost.gradient_scatter(T) * inverse;
  covariance.diagonal().head<3>().array() += shared_error_rad * shared_error_rad;
  covariance.diagonal().tail<3>().array() += shared_error_m * shared_error_m;
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace

std::optional<PoseEstimate> refine_information(const CameraScene& scene, const CameraTask& camera,
                                               const CameraIntrinsics& intrinsics, const SE3& start_T_base_camera,
                                               const RunContext& context) {
  const SurfaceCodes codes = surface_codes(scene.samples);
  const CameraModel model(intrinsics);
  SightingOptions wanted;
  wanted.max_samples = occluding_samples;
  wanted.max_sightings = max_sightings;
  wanted.silhouette_cells = silhouette_cells;
  wanted.margin_px = margin_px;
  // While images are small few are looked at, of what few samples hide; the next level begins where that ends.
  SightingOptions coarse = wanted;
  coarse.max_samples = coarse_occluding_samples;
  coarse.max_sightings = coarse_sightings;
  PoseEstimate estimate;
  SE3& T = estimate.T_base_camera;
  T = start_T_base_camera;
  SE3 seen_from = T;
  std::vector<Sighting> sightings = find_sightings(scene, codes, camera, model, T, coarse);
  for (const int halvings : {2, 1, 0}) {
    if (halvings == 0 || has_moved(seen_from, T, moved_rad, moved_m)) {
      sightings = find_sightings(scene, codes, camera, model, T, halvings > 0 ? coarse : wanted);
      seen_from = T;
    }
    if (context.cancelled() || static_cast<double>(sightings.size()) < InformationCost::kLeastSeen) return std::nullopt;
    const std::vector<SmoothImage> images =
        information_images(scene, camera, halvings, halvings == 2 ? Shown::brightness : Shown::contrast);
    const InformationCost cost(model, sightings, images);
    const PoseMinimum minimum = minimize_pose(T, {}, [&](const SE3& at) { return cost.derivatives(at); });
    T = minimum.T;
    if (minimum.value > 1.0 - least_information) return std::nullopt;
    if (has_moved(start_T_base_camera, T, lost_rad, lost_m)) return std::nullopt;
    if (halvings == 0) {
      const std::vector<Sighting> some = some_of(sightings, coarse_sightings);
      estimate.covariance = covariance_at(cost, InformationCost(model, some, images), T);
    }
  }
  if (!estimate.covariance.allFinite()) return std::nullopt;
  return estimate;
}

}  // namespace rigcal
