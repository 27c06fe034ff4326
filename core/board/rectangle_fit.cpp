#include "core/board/rectangle_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/geometry/se3.h"

namespace rigcal {
namespace {

using Eigen::Vector2d;

constexpr std::size_t least_points = 6;
constexpr double facing = 0.2;  // cosine between a point's outward direction and its edge's
constexpr int start_angles = 48;
constexpr double start_shift_m = 0.12;  // of the plate's shorter side
constexpr int start_steps = 10;
constexpr int last_steps = 25;
constexpr double turned_apart_rad = to_rad(10.0);
constexpr double shifted_apart = 0.15;  // of the shorter side
constexpr double growth_gate_m = 0.03;

Vector2d edge_normal(double angle, int edge) {
  const Vector2d x(std::cos(angle), std::sin(angle));
  const Vector2d y(-x.y(), x.x());
  const double sign = edge % 2 == 0 ? 1.0 : -1.0;
  return sign * (edge < 2 ? x : y);
}

double half_size(const Vector2d& size, int edge) { return 0.5 * size[edge / 2]; }

int nearest_edge(const OutlinePoint& point, const Vector2d& size, const RectangleFit& fit, double gate) {
  int best = -1;
  double nearest = gate;
  for (int edge = 0; edge < 4; ++edge) {
    const Vector2d normal = edge_normal(fit.angle_rad, edge);
    if (normal.dot(point.outward) < facing) continue;
    const double off = std::abs(normal.dot(point.at - fit.center) - half_size(size, edge) - fit.growth[edge / 2]);
    // A point beside the end of an edge belongs to its neighbour.
    const Vector2d along(-normal.y(), normal.x());
    const double beyond =
        std::max(0.0, std::abs(along.dot(point.at - fit.center)) - 0.5 * size[1 - edge / 2] - growth_gate_m);
    if (std::hypot(off, beyond) < nearest) {
      nearest = std::hypot(off, beyond);
      best = edge;
    }
  }
  return best;
}

// Sum of squares, a point without an edge counting as one at the gate.
double associate(const std::vector<OutlinePoint>& outline, const Vector2d& size, double gate, RectangleFit& fit) {
  fit.edge.assign(outline.size(), -1);
  double cost = 0.0;
  double squares = 0.0;
  double used = 0.0;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    fit.edge[k] = nearest_edge(outline[k], size, fit, gate);
    const double off = fit.edge[k] < 0 ? gate : edge_residual(outline[k], size, fit, fit.edge[k]).value;
    cost += off * off;
    if (fit.edge[k] < 0) continue;
    squares += off * off;
    used += 1.0;
  }
  fit.rms_m = used > 0.0 ? std::sqrt(squares / used) : gate;
  fit.used_share = used / static_cast<double>(outline.size());
  return cost;
}

double refine(const std::vector<OutlinePoint>& outline, const Vector2d& size, double gate, double growth_sigma,
              int steps, RectangleFit& fit) {
  double cost = associate(outline, size, gate, fit);
  double damping = 1e-3;
  for (int step = 0; step < steps; ++step) {
    Eigen::Matrix<double, 5, 5> H = Eigen::Matrix<double, 5, 5>::Zero();
    Eigen::Matrix<double, 5, 1> g = Eigen::Matrix<double, 5, 1>::Zero();
    for (std::size_t k = 0; k < outline.size(); ++k) {
      if (fit.edge[k] < 0) continue;
      const EdgeResidual r = edge_residual(outline[k], size, fit, fit.edge[k]);
      H += r.by_parameters.transpose() * r.by_parameters;
      g += r.by_parameters.transpose() * r.value;
    }
    // In units of a point of 1 cm noise; a little damping where no edge holds a direction.
    const double noise2 = 1e-4;
    const double hold = growth_sigma > 0.0 ? noise2 / (growth_sigma * growth_sigma) : 1e12;
    for (int axis = 0; axis < 2; ++axis) {
      H(3 + axis, 3 + axis) += hold;
      g[3 + axis] += hold * fit.growth[axis];
    }
    H.diagonal().head<3>() *= 1.0 + damping;
    H.diagonal().head<3>().array() += 1e-6;
    const Eigen::Matrix<double, 5, 1> move = -H.ldlt().solve(g);
    if (!move.allFinite()) break;
    RectangleFit next = fit;
    next.angle_rad += move[0];
    next.center += move.segment<2>(1);
    next.growth += move.tail<2>();
    const double next_cost = associate(outline, size, gate, next);
    const bool rests = move.norm() < 1e-7;
    if (next_cost > cost) {
      damping *= 10.0;
      if (rests) break;
      continue;
    }
    damping = std::max(1e-6, 0.3 * damping);
    fit = std::move(next);
    cost = next_cost;
    if (rests) break;
  }
  return cost;
}

double turn_between(double a, double b, bool is_square) {
  const double period = is_square ? 0.5 * pi : pi;
  return std::abs(std::remainder(a - b, period));
}

}  // namespace

EdgeResidual edge_residual(const OutlinePoint& point, const Vector2d& size, const RectangleFit& fit, int edge) {
  const Vector2d normal = edge_normal(fit.angle_rad, edge);
  const Vector2d off = point.at - fit.center;
  EdgeResidual out;
  out.value = normal.dot(off) - half_size(size, edge) - fit.growth[edge / 2];
  out.by_parameters[0] = Vector2d(-normal.y(), normal.x()).dot(off);
  out.by_parameters.segment<2>(1) = -normal.transpose();
  out.by_parameters[3 + edge / 2] = -1.0;
  return out;
}

std::optional<RectangleFit> fit_rectangle(const std::vector<OutlinePoint>& outline, const Vector2d& size, double gate_m,
                                          double growth_sigma_m) {
  if (outline.size() < least_points) return std::nullopt;
  std::vector<Vector2d> places;
  for (const OutlinePoint& p : outline) places.push_back(p.at);
  Vector2d low = places[0];
  Vector2d high = places[0];
  for (const Vector2d& p : places) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double shift = start_shift_m * size.minCoeff();
  const double wide_gate = 3.0 * gate_m;
  std::vector<std::pair<double, RectangleFit>> found;
  for (int k = 0; k < start_angles; ++k) {
    for (int place = 0; place < 9; ++place) {
      RectangleFit fit;
      fit.angle_rad = pi * k / start_angles;
      fit.center = 0.5 * (low + high) + shift * Vector2d(place % 3 - 1, place / 3 - 1);
      const double cost = refine(outline, size, wide_gate, 0.0, start_steps, fit);
      found.emplace_back(cost, std::move(fit));
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  RectangleFit best = found[0].second;
  const bool is_square = std::abs(size.x() - size.y()) < 0.02 * size.maxCoeff();
  double other = 0.0;
  for (const auto& [cost, fit] : found) {
    if (turn_between(fit.angle_rad, best.angle_rad, is_square) < turned_apart_rad &&
        (fit.center - best.center).norm() < shifted_apart * size.minCoeff()) {
      continue;
    }
    other = cost;
    break;
  }
  best.runner_up = other / std::max(found[0].first, 1e-9);
  refine(outline, size, gate_m, growth_sigma_m, last_steps, best);
  return best;
}

std::vector<Vector2d> convex_hull(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const Vector2d& a, const Vector2d& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  if (points.size() < 3) return points;
  const auto left = [](const Vector2d& o, const Vector2d& a, const Vector2d& b) {
    return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x()) > 0.0;
  };
  std::vector<Vector2d> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t first = hull.size();
    for (const Vector2d& p : points) {
      while (hull.size() >= first + 2 && !left(hull[hull.size() - 2], hull.back(), p)) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

double area_of(const std::vector<Vector2d>& hull) {
  double twice = 0.0;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Vector2d& a = hull[k];
    const Vector2d& b = hull[(k + 1) % hull.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * std::abs(twice);
}

Vector2d smallest_rectangle(const std::vector<Vector2d>& hull) {
  Vector2d best(0.0, 0.0);
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Vector2d along = (hull[(k + 1) % hull.size()] - hull[k]).normalized();
    const Vector2d across(-along.y(), along.x());
    Vector2d low = Vector2d::Constant(1e30);
    Vector2d high = Vector2d::Constant(-1e30);
    for (const Vector2d& p : hull) {
      const Vector2d q(along.dot(p), across.dot(p));
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
    const Vector2d sides = high - low;
    if (k == 0 || sides.prod() < best.prod()) best = sides;
  }
  if (best.x() < best.y()) std::swap(best.x(), best.y());
  return best;
}

}  // namespace rigcal
