#include "core/start/trajectory_mixup.h"

#include <Eigen/Geometry>
#include <array>
#include <utility>

#include "core/start/own_view.h"

namespace rigcal {
namespace {

constexpr std::size_t surfels_looked_at = 12000;
constexpr std::size_t least_of_patch = 200;
// By so much more of what was seen must lie on what was seen from other stops. Poses that are merely rough leave more
// than this of it where it is.
constexpr double clear_gain = 0.15;

SE3 taken_as(const SE3& T, TrajectoryMixup mixup) {
  switch (mixup) {
    case TrajectoryMixup::none:
      break;
    case TrajectoryMixup::inverse:
      return T.inverse();
    case TrajectoryMixup::millimetres:
      return {T.R, 0.001 * T.t};
    case TrajectoryMixup::w_first: {
      const Eigen::Quaterniond read(T.R);
      return {Eigen::Quaterniond(read.x(), read.y(), read.z(), read.w()).toRotationMatrix(), T.t};
    }
  }
  return T;
}

}  // namespace

TrajectoryMixup trajectory_mixup(const std::vector<PatchSurfels>& patches, int base,
                                 const std::vector<std::optional<SE3>>& T_G_base) {
  std::vector<PatchSurfels> placed;
  for (const PatchSurfels& p : patches) {
    const auto stop = static_cast<std::size_t>(p.stop);
    if (p.lidar == base && stop < T_G_base.size() && T_G_base[stop]) placed.push_back(p);
  }
  if (placed.size() < 2) return TrajectoryMixup::none;
  placed = thinned(placed, surfels_looked_at, least_of_patch);
  const auto score_of = [&](TrajectoryMixup mixup) {
    std::vector<SE3> poses(T_G_base.size());
    for (std::size_t j = 0; j < poses.size(); ++j) {
      if (T_G_base[j]) poses[j] = taken_as(*T_G_base[j], mixup);
    }
    return agreement(placed, poses);
  };
  TrajectoryMixup best = TrajectoryMixup::none;
  double most = score_of(best) + clear_gain;
  for (const TrajectoryMixup other :
       {TrajectoryMixup::inverse, TrajectoryMixup::w_first, TrajectoryMixup::millimetres}) {
    const double score = score_of(other);
    if (score <= most) continue;
    most = score;
    best = other;
  }
  return best;
}

const char* to_words(TrajectoryMixup mixup) {
  switch (mixup) {
    case TrajectoryMixup::none:
      break;
    case TrajectoryMixup::inverse:
      return "the given poses of the stops seem to be inverses: T_G_base is asked for, from the rig to the world "
             "(p_G = R p_base + t); invert them";
    case TrajectoryMixup::w_first:
      return "the quaternions of the given poses seem to have w first: x y z w is asked for; move w to the end";
    case TrajectoryMixup::millimetres:
      return "the given poses of the stops seem to be in millimetres: metres are asked for; divide by 1000";
  }
  return "";
}

}  // namespace rigcal
