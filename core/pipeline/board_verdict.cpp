#include "core/pipeline/board_verdict.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/median.h"
#include "core/base/text.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/quality/verdict_text.h"

namespace rigcal {
namespace {

constexpr int least_boards = 3;
constexpr double most_lost = 0.25;  // of the stops at which both saw a board
// Of what is asked for: what is found lies between what halves of the boards tell.
constexpr double most_apart = 1.0;
constexpr double most_hold_out = 2.0;
constexpr double sure_sigmas = 3.0;
constexpr double range_worth_m = 0.008;  // offsets smaller than this any LiDAR has
constexpr double dark_worth_m = 0.0008;
constexpr double widest_beam_m = 0.025;    // at an edge
constexpr double uneven_growth_m = 0.012;  // between the two sides of one plate
constexpr double least_lean = 0.02;        // mean square sine of the normals about their mean
constexpr double least_way = 0.3;          // between boards, of their distance
constexpr double least_side = 0.2;         // sine of the bearing to the outermost boards
constexpr double least_depth = 1.3;        // farthest over nearest board

// Mean over the boards by which dark squares seem farther, and its sigma by how the boards differ.
std::pair<double, double> dark_farther(const BoardAdjustment& found, std::size_t sensor) {
  double n = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  for (const BoardPlace& place : found.places) {
    for (const BoardSighting& s : place.sightings) {
      if (static_cast<std::size_t>(s.sensor) != sensor || !s.cloud || !s.cloud->squares) continue;
      const double value = s.cloud->squares->dark_farther_m;
      n += 1.0;
      sum += value;
      squares += value * value;
    }
  }
  if (n < 2.0) return {0.0, 0.0};
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1.0))};
}

}  // namespace

Verdict judge_by_boards(const BoardEvidence& e, const Requirement& require, const std::string& advice) {
  Verdict verdict;
  const double t = translation_bound(e.covariance);
  const double r = rotation_bound(e.covariance);
  if (!e.observable || !(t <= open_translation_m && r <= open_rotation_rad)) {
    fail(verdict, "the boards that it shares with " + e.via + " leave its place open; " + advice);
    return verdict;
  }
  if (!e.converged) {
    fail(verdict, "the adjustment of the boards did not converge; look for poses in which the board moved");
    return verdict;
  }
  if (e.runner_up > ambiguous_share) {
    fail(verdict,
         e.several_boards
             ? "there are boards that look alike, and which is which cannot be told; cover all but one, or give "
               "a rough pose in the rig file"
             : "the board looks the same after half a turn, and another place explains it as well; show it to "
               "both in more poses, give a rough pose in the rig file, or correct inner_corners and size there, if "
               "they are not this board's");
    return verdict;
  }
  if (e.via_failed) {
    fail(verdict, "it was placed by boards that it shares with " + e.via +
                      ", which failed: mend that, or show the board to it and to another sensor at once");
    return verdict;
  }
  if (e.via_agreeing && *e.via_agreeing < least_boards) {
    weaken(verdict, "it was placed by boards that it shares with " + e.via +
                        ", whose own place hangs on the board at " + counted(*e.via_agreeing, "stop") +
                        " only; show it in ten poses");
  }
  if (e.lost_together) {
    weaken(verdict, "from stop " + std::to_string(e.lost.front()) + " to stop " + std::to_string(e.lost.back()) +
                        " the board lies elsewhere by it than by " + e.via + ", though it goes with " +
                        counted(e.agreeing, "other stop") +
                        ": a mount that slipped or was moved during the recording; fasten it and record again");
  } else if (static_cast<double>(e.shared - e.agreeing) >= most_lost * e.shared) {
    weaken(verdict, "only at " + std::to_string(e.agreeing) + " of the " + std::to_string(e.shared) +
                        " stops at which it and " + e.via +
                        " saw a board do these agree; check the board and the cameras' intrinsics in the rig file, and "
                        "that neither rig nor board moved while it was shown");
  } else if (e.agreeing < least_boards) {
    weaken(verdict, "it and " + e.via + " saw the board together at " + counted(e.agreeing, "stop") +
                        " only; show it in ten poses");
  }
  if (t > require.translation_m || r > require.rotation_rad) {
    weaken(verdict, "95 % bounds are " + mm(t) + " and " + deg(r) + ", wanted are " + mm(require.translation_m) +
                        " and " + deg(require.rotation_rad) + (advice.empty() ? "; add board poses" : "; " + advice));
  }
  if (e.halves.compared && e.halves.chi2 > differing_chi2 &&
      (e.halves.translation_m > most_apart * require.translation_m ||
       e.halves.rotation_rad > most_apart * require.rotation_rad)) {
    weaken(verdict, "boards before stop " + std::to_string(e.halves.first_later_stop) + " and from it on give places " +
                        mm(e.halves.translation_m) + " and " + deg(e.halves.rotation_rad) +
                        " apart: a mount that slipped or was moved during the recording, or intrinsics in the rig "
                        "file that are off; look after both and record again");
  }
  if (e.focal.sigma > 0.0 && std::abs(e.focal.off) > sure_sigmas * e.focal.sigma &&
      (e.focal.moves_m > require.translation_m || e.focal.moves_rad > require.rotation_rad)) {
    weaken(verdict, "by the boards its focal length is " + number(100.0 * std::abs(e.focal.off), 1) + " % too " +
                        (e.focal.off > 0.0 ? "long" : "short") + " in the rig file, which moves it by " +
                        mm(e.focal.moves_m) + " and " + deg(e.focal.moves_rad) +
                        "; calibrate its intrinsics anew, or have them found by --refine-intrinsics");
  }
  if (e.hold_out > most_hold_out) {
    weaken(verdict, "boards that were left out are off by " + number(e.hold_out, 1) +
                        " times their noise; look for poses in which the board moved");
  }
  return verdict;
}

std::string advice_on_poses(const BoardAdjustment& found, std::size_t sensor) {
  const SE3 T_sensor_base = found.sensors[sensor].T_base_sensor.inverse();
  Matrix3d spread = Matrix3d::Zero();
  Vector3d mean = Vector3d::Zero();
  std::vector<Vector3d> normals;
  double left = 0.0;
  double right = 0.0;
  double near = 1e9;
  double far = 0.0;
  for (const BoardPlace& place : found.places) {
    const bool seen = std::any_of(place.sightings.begin(), place.sightings.end(),
                                  [&](const BoardSighting& s) { return static_cast<std::size_t>(s.sensor) == sensor; });
    if (!seen || !place.why_out.empty() || place.sightings.size() < 2) continue;
    normals.push_back(T_sensor_base.R * place.T_base_board.R.col(2));
    mean += normals.back();
    const Vector3d p = T_sensor_base * place.T_base_board.t;
    const bool is_camera = found.sensors[sensor].camera.has_value();
    const double side = is_camera ? p.x() / p.norm() : -p.y() / p.norm();
    left = std::min(left, side);
    right = std::max(right, side);
    near = std::min(near, p.norm());
    far = std::max(far, p.norm());
  }
  if (normals.empty()) return "show the board to it and to another sensor at once";
  mean.normalize();
  for (const Vector3d& n : normals) {
    const Vector3d off = n - mean * mean.dot(n);
    spread += off * off.transpose() / static_cast<double>(normals.size());
  }
  const SymmetricEigen eigen = symmetric_eigen(spread);
  if (eigen.values[1] < least_lean) {
    const Vector3d axis = eigen.vectors.col(1);
    const bool is_camera = found.sensors[sensor].camera.has_value();
    const bool upright = std::abs(is_camera ? axis.y() : axis.z()) > 0.7;
    if (eigen.values[2] < least_lean) return "add poses in which the board leans by 30 degrees to all four sides";
    return upright ? "add poses in which the board leans forwards and backwards by 30 degrees"
                   : "add poses in which the board is turned to the left and to the right by 30 degrees";
  }
  if (left > -least_side) return "add poses at the left of what it sees";
  if (right < least_side) return "add poses at the right of what it sees";
  if (far < least_depth * near) return "add poses nearer and farther away, by a half and more";
  return normals.size() < 10 ? "add board poses, ten or more, near and far" : std::string();
}

std::optional<RangeOffset> remarkable_offset(const BoardAdjustment& found, std::size_t sensor) {
  const double offset = found.sensors[sensor].range_offset_m;
  const double sigma = found.range_offset_sigma_m[sensor];
  if (sigma <= 0.0 || std::abs(offset) < std::max(range_worth_m, sure_sigmas * sigma)) return std::nullopt;
  return RangeOffset{-offset, sigma};
}

std::vector<std::string> findings_of(const BoardAdjustment& found, const BoardModel& board) {
  std::vector<std::string> out;
  for (std::size_t s = 0; s < found.sensors.size(); ++s) {
    const BoardSensor& sensor = found.sensors[s];
    if (sensor.camera) continue;
    if (const auto offset = remarkable_offset(found, s)) {
      out.push_back("the ranges of " + sensor.name + " are " + mm(std::abs(offset->value_m)) + " too " +
                    (offset->value_m > 0.0 ? "long" : "short") + " by the boards (sigma " + mm(offset->sigma_m) +
                    "), which was taken into account");
    }
    const auto [farther, spread] = dark_farther(found, s);
    if (std::abs(farther) > std::max(dark_worth_m, sure_sigmas * spread)) {
      out.push_back("dark squares seem " + mm(std::abs(farther)) + (farther > 0.0 ? " farther" : " nearer") + " to " +
                    sensor.name + " than bright ones (sigma " + mm(spread) + "), which was taken out");
    }
    const Eigen::Vector2d growth = sensor.growth_m;
    const double uneven = std::abs(growth.x() - growth.y());
    if (growth.cwiseAbs().maxCoeff() > widest_beam_m || uneven > uneven_growth_m) {
      const Eigen::Vector2d size = board.size() + 2.0 * growth;
      out.push_back("the plate measures " + number(size.x(), 3) + " by " + number(size.y(), 3) + " m by " +
                    sensor.name + ", but the rig file's board.size is " + number(board.size().x(), 3) + " by " +
                    number(board.size().y(), 3) + " m; measure it");
    }
  }
  return out;
}

std::string doubt_of_corners(const std::vector<BoardSighting>& sightings, const BoardModel& board) {
  if (board.has_markers()) return {};
  std::map<std::pair<int, int>, int> parts;
  int all = 0;
  for (const BoardSighting& s : sightings) {
    if (!s.image) continue;
    if (s.image->whole) return {};
    int columns = 0;
    int rows = 0;
    for (const int id : s.image->ids) {
      columns = std::max(columns, id % board.columns() + 1);
      rows = std::max(rows, id / board.columns() + 1);
    }
    // A part may be found with its rows along the board's columns.
    ++parts[{std::max(columns, rows), std::min(columns, rows)}];
    ++all;
  }
  const auto usual =
      std::max_element(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (usual == parts.end() || usual->second < least_boards || 2 * usual->second < all) return {};
  return "no image shows a whole board of " + std::to_string(board.columns()) + " by " + std::to_string(board.rows()) +
         " inner corners, but " + std::to_string(usual->second) + " of " + std::to_string(all) + " show " +
         std::to_string(usual->first.first) + " by " + std::to_string(usual->first.second) +
         ": count the corners between the squares, not the squares, for board.inner_corners in the rig file";
}

double scale_between(const std::vector<BoardSighting>& sightings) {
  std::vector<double> ratios;
  for (const BoardSighting& a : sightings) {
    for (const BoardSighting& b : sightings) {
      if (!a.cloud || !b.cloud || a.sensor != b.sensor || a.stop >= b.stop) continue;
      const double by_lidar = (a.T_sensor_board.t - b.T_sensor_board.t).norm();
      if (by_lidar < least_way * a.T_sensor_board.t.norm()) continue;
      for (const BoardSighting& c : sightings) {
        if (!c.image || !c.image->whole || c.stop != a.stop) continue;
        for (const BoardSighting& d : sightings) {
          if (d.sensor != c.sensor || !d.image || !d.image->whole || d.stop != b.stop) continue;
          ratios.push_back(by_lidar / std::max(1e-9, (c.T_sensor_board.t - d.T_sensor_board.t).norm()));
        }
      }
    }
  }
  return ratios.size() < 3 ? 0.0 : median(ratios);
}

}  // namespace rigcal
