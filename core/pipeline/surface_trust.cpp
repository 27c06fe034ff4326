#include "core/pipeline/surface_trust.h"

#include <algorithm>

namespace rigcal {
namespace {

// Unevenness beyond noise that only real surfaces have.
constexpr double uneven_m = 0.003;

// Where ranges show no error of their own, surfaces count as flat as they show themselves to be, down to here, as far
// as leaves tell that are no smaller.
constexpr double least_floor_m = 0.0003;
constexpr double least_trusted_leaf_m = 0.5;

}  // namespace

void SurfaceTrust::set_gates(RefinePass& pass) const {
  PlaneMapOptions& map = pass.map;
  if (trust_noise_) {
    pass.trust_noise = true;
    if (seen_at_gates_m_) map.offset_floor_m = std::clamp(*seen_at_gates_m_, least_floor_m, map.offset_floor_m);
  }
  // Roads and hedges are no planes to a millimetre; gates for what is one would keep the few leaves that happen to
  // agree.
  if (unevenness_m() == 0.0) return;
  map.offset_floor_m = std::max(map.offset_floor_m, seen_m_);
  map.gate_slack_m = seen_m_;
  map.max_chi2 = 3.0;
}

void SurfaceTrust::look_loosely(const PlaneMap& map, const RigState& state, double floor_of_map_m) {
  seen_m_ = unexplained_offset(map, state, floor_of_map_m);
}

void SurfaceTrust::look_at_gates(const PlaneMap& map, const RigState& state, double floor_of_map_m) {
  seen_at_gates_m_ = unexplained_offset(map, state, floor_of_map_m, least_trusted_leaf_m);
}

double SurfaceTrust::unevenness_m() const { return seen_m_ < uneven_m ? 0.0 : seen_m_; }

Matrix6d with_unevenness(const Matrix6d& covariance, double unevenness_m, std::size_t stops) {
  constexpr double lever_m = 5.0;
  Matrix6d out = covariance;
  const double variance = unevenness_m * unevenness_m / static_cast<double>(stops);
  out.diagonal().head<3>().array() += variance / (lever_m * lever_m);
  out.diagonal().tail<3>().array() += variance;
  return out;
}

}  // namespace rigcal
