#include "core/board/plate_candidate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/text.h"

namespace rigcal {
namespace {

constexpr double match_error_m = 0.06;  // Mean distance of a cluster's points from the template laid on them.

using Eigen::Vector2d;

constexpr double least_overlap = 0.6;
constexpr double most_overlap = 1.2;
constexpr double border_gate_m = 0.04;
constexpr double growth_sigma_m = 0.01;
constexpr double most_border_rms_m = 0.025;
constexpr double least_used = 0.7;
constexpr std::size_t least_border = 8;
constexpr int least_per_axis = 2;
constexpr double most_plane_sigma_m = 0.035;
constexpr double stray_sigmas = 3.0;
constexpr double mixed_m = 0.015;
constexpr double size_tolerance = 0.12;  // of a side, within which a piece comes near to the plate in size

// Nearest place of a rectangle of lattice points: the point itself, held within the plate.
Vector2d nearest_in(const Vector2d& p, const Vector2d& size) { return p.cwiseMax(-0.5 * size).cwiseMin(0.5 * size); }

double inside_by(const Vector2d& p, const Vector2d& size) { return (0.5 * size - p.cwiseAbs()).minCoeff(); }

std::string size_words(const Vector2d& sides) {
  return number_text(std::round(1e3 * sides.x()) / 1e3) + " by " + number_text(std::round(1e3 * sides.y()) / 1e3) +
         " m";
}

Vector2d longer_first(Vector2d size) {
  if (size.x() < size.y()) std::swap(size.x(), size.y());
  return size;
}

// The template of the board (every place of the plate) as it lies on points in the plane's two axes.
struct TemplateMatch {
  double angle_rad = 0.0;
  Vector2d center = Vector2d::Zero();
  double error_m = 0.0;  // mean distance of a point from it
};

// By ICP from twelve turns: the one with the least error.
TemplateMatch match_template(const std::vector<Vector2d>& points, const Vector2d& size) {
  TemplateMatch best;
  best.error_m = 1e9;
  if (points.empty()) return best;
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& p : points) mean += p / static_cast<double>(points.size());
  for (int start = 0; start < 12; ++start) {
    TemplateMatch match{pi * start / 12.0, mean, 0.0};
    for (int step = 0; step < 20; ++step) {
      const Eigen::Rotation2Dd R(match.angle_rad);
      // Kabsch in the plane: template places q onto points p.
      Vector2d p_mean = Vector2d::Zero();
      Vector2d q_mean = Vector2d::Zero();
      std::vector<Vector2d> q(points.size());
      match.error_m = 0.0;
      for (std::size_t k = 0; k < points.size(); ++k) {
        const Vector2d local = R.inverse() * (points[k] - match.center);
        q[k] = nearest_in(local, size);
        match.error_m += (local - q[k]).norm() / static_cast<double>(points.size());
        p_mean += points[k] / static_cast<double>(points.size());
        q_mean += q[k] / static_cast<double>(points.size());
      }
      double co = 0.0;
      double si = 0.0;
      for (std::size_t k = 0; k < points.size(); ++k) {
        const Vector2d a = q[k] - q_mean;
        const Vector2d b = points[k] - p_mean;
        co += a.dot(b);
        si += a.x() * b.y() - a.y() * b.x();
      }
      const double angle = std::atan2(si, co);
      const bool rests = std::abs(std::remainder(angle - match.angle_rad, 2.0 * pi)) < 1e-5;
      match.angle_rad = angle;
      match.center = p_mean - Eigen::Rotation2Dd(angle) * q_mean;
      if (rests) break;
    }
    if (match.error_m < best.error_m) best = match;
  }
  return best;
}

}  // namespace

SE3 plane_frame(const FittedPlane& plane, const Vector3d& origin) {
  const Vector3d away = -plane.normal;
  const Vector3d helper = std::abs(away.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX();
  const Vector3d x = helper.cross(away).normalized();
  SE3 frame;
  frame.R << x, away.cross(x), away;
  frame.t = origin - plane.distance(origin) * plane.normal;
  return frame;
}

PlateFit fit_plate(const PlateCandidate& candidate, const BoardModel& board) {
  PlateFit out;
  const SE3 frame = plane_frame(candidate.plane, candidate.plane.points.mean());
  const SE3 to_plane = frame.inverse();
  std::vector<Vector2d> flat;
  for (const Vector3d& p : candidate.points) flat.push_back((to_plane * p).head<2>());
  std::vector<OutlinePoint> outline;
  for (std::size_t k = 0; k < candidate.outline.size(); ++k) {
    const Vector2d outward = (to_plane.R * candidate.outward[k]).head<2>();
    outline.push_back({(to_plane * candidate.outline[k]).head<2>(), outward.normalized()});
  }
  std::vector<Vector2d> all = flat;
  for (const OutlinePoint& p : outline) all.push_back(p.at);
  const std::vector<Vector2d> hull = convex_hull(all);
  out.sides = smallest_rectangle(hull);
  const double area = candidate.area_m2 > 0.0 ? candidate.area_m2 : area_of(hull);
  const double share = area / board.size().prod();
  if (share < least_overlap || share > most_overlap) {
    out.why_not = "it covers " + number_text(std::round(100.0 * share)) + " % of the plate's area";
    return out;
  }
  if (candidate.plane.sigma_m > most_plane_sigma_m) {
    out.why_not = "it is not flat";
    return out;
  }
  const TemplateMatch match = match_template(flat, board.size());
  if (match.error_m > match_error_m) {
    out.why_not = "its shape is another";
    return out;
  }
  const auto fit = outline.size() < least_border ? std::nullopt
                                                 : fit_rectangle(outline, board.size(), border_gate_m, growth_sigma_m);
  if (!fit) {
    out.why_not = "too little of its outline is seen";
    return out;
  }
  std::array<int, 2> seen{};
  for (const int edge : fit->edge) {
    if (edge >= 0) ++seen[static_cast<std::size_t>(edge / 2)];
  }
  if (std::min(seen[0], seen[1]) < least_per_axis) {
    out.why_not = "two of its edges are not seen (turn the board so that no edge runs along the rings)";
    return out;
  }
  if (fit->used_share < least_used || fit->rms_m > most_border_rms_m) {
    out.why_not = "its outline is no rectangle of that size (" + number_text(std::round(1e3 * fit->rms_m)) + " mm rms)";
    return out;
  }
  CloudBoard& found = out.board.emplace();
  SE3 in_plane;
  in_plane.R = exp_so3({0.0, 0.0, fit->angle_rad});
  in_plane.t << fit->center, 0.0;
  found.T_lidar_board = frame * in_plane;
  const SE3 to_board = found.T_lidar_board.inverse();
  const double tolerance = stray_sigmas * candidate.plane.sigma_m;
  double squares = 0.0;
  for (const Vector3d& p : candidate.points) {
    const Vector3d q = to_board * p;
    // Beams that meet the edge come back from between the plate and what is behind it.
    if (std::abs(q.z()) > tolerance || inside_by(q.head<2>(), board.size()) < mixed_m) continue;
    found.points.push_back(p);
    squares += q.z() * q.z();
  }
  found.plane_rms_m = std::sqrt(squares / std::max<double>(1.0, static_cast<double>(found.points.size())));
  found.border_rms_m = fit->rms_m;
  found.growth_m = fit->growth;
  found.overlap = share;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    if (fit->edge[k] < 0) continue;
    found.border.push_back(
        {candidate.outline[k], fit->edge[k] / 2, fit->edge[k] % 2 == 0 ? 1 : -1, candidate.outline_sigma_m});
  }
  return out;
}

std::string why_no_plate(const std::vector<PlateFit>& fits, const BoardModel& board) {
  const Vector2d wanted = longer_first(board.size());
  const PlateFit* nearest = nullptr;
  double off = 1e9;
  for (const PlateFit& fit : fits) {
    const double distance = (fit.sides - wanted).cwiseAbs().cwiseQuotient(wanted).maxCoeff();
    if (distance < off) {
      off = distance;
      nearest = &fit;
    }
  }
  const std::string none = "no flat piece of " + size_words(wanted) + " that stands free";
  if (nearest == nullptr) return none;
  if (off < size_tolerance)
    return none + "; the nearest is one of " + size_words(nearest->sides) + ", but " + nearest->why_not;
  return none + "; the nearest in size is one of " + size_words(nearest->sides) +
         " (where that is the board, correct its size in the rig file)";
}

void take_turn(CloudBoard& found, const SE3& turn) {
  const SE3 back = turn.inverse();
  found.T_lidar_board = found.T_lidar_board * turn;
  if (found.squares) found.squares->T_lidar_pattern = found.squares->T_lidar_pattern * turn;
  for (BorderPoint& p : found.border) {
    Vector3d normal = Vector3d::Zero();
    normal[p.axis] = p.sign;
    normal = back.R * normal;
    p.axis = std::abs(normal.x()) > std::abs(normal.y()) ? 0 : 1;
    p.sign = normal[p.axis] > 0.0 ? 1 : -1;
  }
  if (std::abs(turn.R(0, 1)) > 0.5) std::swap(found.growth_m.x(), found.growth_m.y());
}

}  // namespace rigcal
