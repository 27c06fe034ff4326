#include "core/start/rig_drive.h"

#include <cmath>

#include "core/start/axis_search.h"
#include "core/start/drive.h"
#include "core/start/hand_eye.h"
#include "core/start/own_view.h"
#include "core/start/stop_poses.h"

namespace rigcal {
namespace {

// What they saw lies better on itself then by this, where the poses are others: the same ones agree to a thousandth.
constexpr double drive_gain = 0.003;
// Of what the LiDARs of a table that turned saw, so much lies on what they saw from other stops, unless it did not.
constexpr double table_agreement = 0.94;
// A stop that stands elsewhere by this has moved; so much of the squares of the normals must lie along its way.
constexpr double elsewhere_m = 0.1;
constexpr double told_share = 0.03;

bool drove(const Start& start) {
  const std::optional<TurnOfPoses> turn = turn_of_poses(start.state.T_G_base, start.stop_known);
  return turn && turn->drove();
}

// Whether surfaces tell of most of the stops that they stand there and not where they were thought to. Along a corridor
// nothing does, and any places fit.
bool are_told(const std::vector<PatchSurfels>& rig, const std::vector<SE3>& before, const std::vector<SE3>& after) {
  std::size_t moved = 0;
  std::size_t told = 0;
  for (const PatchSurfels& p : rig) {
    const auto j = static_cast<std::size_t>(p.stop);
    const Vector3d way = after[j].t - before[j].t;
    if (way.norm() < elsewhere_m) continue;
    double facing = 0.0;
    for (const Surfel& s : p.surfels) facing += std::pow((after[j].R * s.normal).dot(way.normalized()), 2);
    ++moved;
    if (facing >= told_share * static_cast<double>(p.surfels.size())) ++told;
  }
  return told > 0 && 2 * told >= moved;
}

}  // namespace

std::vector<PatchSurfels> seen_by_rig(const StartInput& input, const std::vector<PatchSurfels>& patches,
                                      const Start& start) {
  std::vector<PatchSurfels> out(static_cast<std::size_t>(input.stops));
  for (const PatchSurfels& p : patches) {
    const auto i = static_cast<std::size_t>(p.lidar);
    if (!start.lidar_known[i] || !start.stop_known[static_cast<std::size_t>(p.stop)]) continue;
    const SE3& T = start.state.T_base_sensor[i];
    for (Surfel s : p.surfels) {
      s.mean = T * s.mean;
      s.normal = T.R * s.normal;
      out[static_cast<std::size_t>(p.stop)].surfels.push_back(s);
    }
  }
  for (int j = 0; j < input.stops; ++j) {
    out[static_cast<std::size_t>(j)].lidar = input.base;
    out[static_cast<std::size_t>(j)].stop = j;
  }
  std::erase_if(out, [](const PatchSurfels& p) { return p.surfels.empty(); });
  return out;
}

bool drive_with_all(const StartInput& input, const std::vector<PatchSurfels>& patches, Start& start) {
  const std::vector<PatchSurfels> rig = seen_by_rig(input, patches, start);
  const double before = balanced_agreement(rig, start.state.T_G_base);
  if (!drove(start) && before >= table_agreement) return false;
  std::vector<Matrix3d> R_G_base;
  for (const SE3& T : start.state.T_G_base) R_G_base.push_back(T.R);
  Start other = start;
  other.state.T_G_base = poses_of_drive(rig, R_G_base);
  refine_stops(input, rig, loose_hold, other);
  const double after = balanced_agreement(rig, other.state.T_G_base);
  if (after <= before + drive_gain || !are_told(rig, start.state.T_G_base, other.state.T_G_base)) return false;
  start.state.T_G_base = other.state.T_G_base;
  return true;
}

}  // namespace rigcal
