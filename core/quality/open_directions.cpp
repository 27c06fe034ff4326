#include "core/quality/open_directions.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/geometry/chi_square.h"
#include "core/planes/plane_factor.h"
#include "core/quality/verdict_text.h"

namespace rigcal {
namespace {

constexpr double along_axis = 0.966;  // within 15 degrees

// Axes in the base frame, the worst known last.
struct Axes {
  Matrix3d vectors;
  Vector3d bounds;
};

Axes axes_of(const Matrix3d& C_sensor, const SE3& T_base_sensor) {
  const Matrix3d& R = T_base_sensor.R;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(R * C_sensor * R.transpose());
  return {solver.eigenvectors(), (chi2_95_3 * solver.eigenvalues().cwiseMax(0.0)).cwiseSqrt()};
}

Axes place_axes(const Matrix6d& C, const SE3& T) { return axes_of(C.bottomRightCorner<3, 3>(), T); }
Axes turn_axes(const Matrix6d& C, const SE3& T) { return axes_of(C.topLeftCorner<3, 3>(), T); }

int count_beyond(const Axes& axes, double limit) { return static_cast<int>((axes.bounds.array() > limit).count()); }

bool is_vertical(const Vector3d& d) { return std::abs(d.z()) > along_axis; }
bool is_level(const Vector3d& d) { return std::abs(d.z()) < std::sqrt(1.0 - along_axis * along_axis); }

std::string open_place(const Axes& axes, int open) {
  if (open == 3) return "its place";
  if (open == 1) return "its place along " + direction_words(axes.vectors.col(2));
  const Vector3d held = axes.vectors.col(0);
  return "its place along all directions across " + direction_words(held) +
         (is_vertical(held) ? " (all level ones)" : "");
}

std::string open_turn(const Axes& axes, int open) {
  if (open == 3) return "its rotation";
  if (open == 1) return "its turn about " + direction_words(axes.vectors.col(2));
  return "its turns about all axes across " + direction_words(axes.vectors.col(0));
}

std::string surface_along(const Vector3d& d) {
  if (is_vertical(d)) return "a level surface (a floor, a ceiling, a table)";
  return (is_level(d) ? "an upright surface that faces along " : "a surface that faces along ") + direction_words(d);
}

std::string surfaces_for_place(const Axes& place, int open) {
  if (open == 1) return surface_along(place.vectors.col(2));
  if (open == 3) return "surfaces that face three ways";
  return is_vertical(place.vectors.col(0)) ? "upright flat surfaces that face two ways"
                                           : "flat surfaces that face two more ways";
}

// A flat surface does not hold the turn about its own normal.
std::string surface_across(const Vector3d& axis) {
  return is_vertical(axis) ? "an upright flat surface"
                           : "a large flat surface that does not face along " + direction_words(axis);
}

void add_axes(const Axes& axes, double limit, double open_limit, WeakDirection one, const Vector3d& frozen,
              std::vector<WeakDirection>& out) {
  for (int k = 2; k >= 0 && axes.bounds[k] > limit; --k) {
    one.axis = axes.vectors.col(k);
    one.bound = axes.bounds[k];
    one.is_open = one.bound > open_limit;
    one.is_frozen = !one.is_open && !one.is_turn && std::abs(one.axis.dot(frozen)) > along_axis;
    one.missing = one.is_turn ? surface_across(one.axis) : surface_along(one.axis);
    out.push_back(one);
  }
}

// Over stops that saw something; by any axis, for a table turns about one.
double widest_turn(const SolvedPlanes& solved) {
  std::vector<char> seen(static_cast<std::size_t>(solved.layout.stops()), 0);
  for (const PlaneFeature& feature : solved.features) {
    for (const PlaneObservation& o : feature.observations) seen[static_cast<std::size_t>(o.stop)] = 1;
  }
  double widest = 0.0;
  for (std::size_t a = 0; a < seen.size(); ++a) {
    for (std::size_t b = 0; b < a && seen[a]; ++b) {
      if (!seen[b]) continue;
      widest = std::max(widest, rotation_distance(solved.state.T_G_base[a].R, solved.state.T_G_base[b].R));
    }
  }
  return widest;
}

}  // namespace

OpenDirections open_directions(const Matrix6d& covariance, const SE3& T_base_sensor) {
  const Axes place = place_axes(covariance, T_base_sensor);
  const Axes turn = turn_axes(covariance, T_base_sensor);
  const int places = count_beyond(place, open_translation_m);
  const int turns = count_beyond(turn, open_rotation_rad);
  OpenDirections out;
  if (places > 0) {
    out.what = open_place(place, places);
    out.surface = surfaces_for_place(place, places);
  }
  if (turns > 0) {
    out.what += (places > 0 ? " and " : "") + open_turn(turn, turns);
    if (places == 0)
      out.surface = turns > 1 ? "larger surfaces that face three ways" : surface_across(turn.vectors.col(2));
  }
  return out;
}

std::vector<WeakDirection> weak_directions(const Matrix6d& covariance, const SE3& T_base_sensor,
                                           const Requirement& require, const Vector3d& frozen) {
  std::vector<WeakDirection> out;
  WeakDirection one;
  add_axes(place_axes(covariance, T_base_sensor), require.translation_m, open_translation_m, one,
           T_base_sensor.R * frozen, out);
  one.is_turn = true;
  add_axes(turn_axes(covariance, T_base_sensor), require.rotation_rad, open_rotation_rad, one, Vector3d::Zero(), out);
  return out;
}

std::string surface_for_weak_translation(const Matrix6d& covariance, const SE3& T_base_sensor) {
  return surface_along(place_axes(covariance, T_base_sensor).vectors.col(2));
}

std::optional<HelpfulTurn> turn_for_weak_translation(const SolvedPlanes& solved, int lidar,
                                                     const Matrix6d& covariance) {
  const SE3& T_base_sensor = solved.state.T_base_sensor[static_cast<std::size_t>(lidar)];
  const Vector3d d = place_axes(covariance, T_base_sensor).vectors.col(2);
  if (!is_level(d)) return std::nullopt;
  constexpr double faces = 0.5;  // within 60 degrees
  double facing = 0.0;
  double all = 0.0;
  // Upright surfaces by how far they would have to be turned, as angles doubled: a normal is as good as its opposite.
  double cosines = 0.0;
  double sines = 0.0;
  PlaneDerivatives plane;
  for (const PlaneFeature& feature : solved.features) {
    const auto is_its = [&](const PlaneObservation& o) { return o.lidar == lidar && o.offset_variance > 0.0; };
    if (feature.merged || std::none_of(feature.observations.begin(), feature.observations.end(), is_its)) continue;
    plane_derivatives(feature, solved.state, HessianForm::gauss_newton, plane);
    for (const PlaneObservation& o : feature.observations) {
      if (!is_its(o)) continue;
      const Vector3d n = solved.state.T_G_base[static_cast<std::size_t>(o.stop)].R.transpose() * plane.normal;
      if (!is_level(n)) continue;
      const double weight = 1.0 / o.offset_variance;
      all += weight;
      if (std::abs(n.dot(d)) > faces) facing += weight;
      const double apart = std::atan2(d.y(), d.x()) - std::atan2(n.y(), n.x());
      cosines += weight * std::cos(2.0 * apart);
      sines += weight * std::sin(2.0 * apart);
    }
  }
  constexpr double least_share = 0.1;
  if (all == 0.0 || facing > least_share * all) return std::nullopt;
  // The rig is turned the other way than what it sees.
  return HelpfulTurn{-0.5 * std::atan2(sines, cosines), widest_turn(solved)};
}

std::string turn_words(const std::optional<HelpfulTurn>& turn) {
  if (!turn) return {};
  return ", or stops after a turn of about " + number(std::abs(to_deg(turn->by_rad)), 0) +
         " degrees (so far the rig turned by " + number(to_deg(turn->seen_rad), 0) +
         " degrees at most): then surfaces that it has seen face that way";
}

}  // namespace rigcal
