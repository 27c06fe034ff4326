#include "core/start/turning.h"

#include <cmath>
#include <cstdlib>

#include "core/geometry/symmetric_solve.h"
#include "core/start/surfel_index.h"

namespace rigcal {
namespace {

// One Gauss-Newton step for the foot f over all pairs of surfels of stops at most `max_steps` apart.
Vector3d foot_step(const std::vector<PatchSurfels>& patches, const std::vector<Matrix3d>& R, const Vector3d& f,
                   double tolerance, int max_steps) {
  std::vector<PlacedSurfel> placed;
  for (const PatchSurfels& patch : patches) {
    const Matrix3d& Rj = R[static_cast<std::size_t>(patch.stop)];
    // Three unknowns: some hundred surfels a stop are plenty.
    const std::size_t step = std::max<std::size_t>(1, patch.surfels.size() / 400);
    for (std::size_t i = 0; i < patch.surfels.size(); i += step) {
      const Surfel& s = patch.surfels[i];
      placed.push_back({Rj * s.mean + f - Rj * f, Rj * s.normal, patch.stop});
    }
  }
  const SurfelIndex index(placed, std::max(0.6, tolerance));
  const double min_cosine = std::cos(to_rad(12.0));
  Matrix3d H = Matrix3d::Zero();
  Vector3d g = Vector3d::Zero();
  std::vector<int> partners;
  for (const PlacedSurfel& a : placed) {
    index.find_all(a.mean, a.normal, min_cosine, tolerance, a.group, 8, partners);
    for (const int partner : partners) {
      const PlacedSurfel& b = index[partner];
      if (std::abs(a.group - b.group) > max_steps) continue;
      const double r = b.normal.dot(a.mean - b.mean);
      const Vector3d J =
          (R[static_cast<std::size_t>(b.group)] - R[static_cast<std::size_t>(a.group)]).transpose() * b.normal;
      const double w = 1.0 / (1.0 + 4.0 * r * r / (tolerance * tolerance));
      H += w * J * J.transpose();
      g += w * r * J;
    }
  }
  H.diagonal().array() += 1e-3 * H.trace() + 1e-9;
  return f - solve_symmetric3(H, g);
}

}  // namespace

std::vector<SE3> poses_from_rotations(const std::vector<PatchSurfels>& base_patches,
                                      const std::vector<Matrix3d>& R_G_base) {
  Vector3d f = Vector3d::Zero();
  // First neighbours only, which the unknown foot displaces least; then all pairs, when it is nearly right.
  struct Pass {
    double tolerance;
    int max_steps;
    int repeats;
  };
  for (const Pass pass : {Pass{0.6, 1, 4}, Pass{0.4, 2, 4}, Pass{0.2, 1000, 4}, Pass{0.1, 1000, 3}}) {
    for (int k = 0; k < pass.repeats; ++k) f = foot_step(base_patches, R_G_base, f, pass.tolerance, pass.max_steps);
  }
  std::vector<SE3> poses;
  for (const Matrix3d& R : R_G_base) poses.push_back({R, f - R * f});
  return poses;
}

}  // namespace rigcal
