#include "core/planes/damped_passes.h"

#include <cmath>

namespace rigcal {
namespace {

// How far away a turn is seen, m: moves of rotations and of places are put together.
constexpr double lever_m = 10.0;
// Cosine between two moves one of which undoes the other.
constexpr double most_undone = -0.5;

Vector6d move_of(const SE3& before, const SE3& after) {
  Vector6d xi = (before.inverse() * after).log();
  xi.head<3>() *= lever_m;
  return xi;
}

SE3 halfway(const SE3& a, const SE3& b) { return a * SE3::exp(0.5 * (a.inverse() * b).log()); }

}  // namespace

void DampedPasses::take(const RigState& before, RigState& state) {
  std::vector<Vector6d> moves;
  double dot = 0.0;
  double square = 0.0;
  double last_square = 0.0;
  for (std::size_t i = 0; i < state.T_base_sensor.size(); ++i) {
    moves.push_back(move_of(before.T_base_sensor[i], state.T_base_sensor[i]));
    if (last_.empty()) continue;
    dot += moves[i].dot(last_[i]);
    square += moves[i].squaredNorm();
    last_square += last_[i].squaredNorm();
  }
  last_ = std::move(moves);
  if (dot >= most_undone * std::sqrt(square * last_square)) return;
  for (std::size_t i = 0; i < state.T_base_sensor.size(); ++i) {
    state.T_base_sensor[i] = halfway(before.T_base_sensor[i], state.T_base_sensor[i]);
  }
  for (std::size_t j = 0; j < state.T_G_base.size(); ++j) {
    state.T_G_base[j] = halfway(before.T_G_base[j], state.T_G_base[j]);
  }
}

}  // namespace rigcal
