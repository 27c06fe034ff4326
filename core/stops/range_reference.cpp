#include "core/stops/range_reference.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/median.h"

namespace rigcal {
namespace {

// A cube's six faces, each cut into squares of equal tangent: 2.6 degrees in the middle, 1.3 at the corners, where
// patterns are thinner too. Smaller squares have too few points of a tenth of a second, larger ones too many edges.
constexpr int cells_a_side = 44;
constexpr int cells_a_face = cells_a_side * cells_a_side;
constexpr double half_side = 0.5 * cells_a_side;

constexpr double fewest_points = 6.0;
// Spread of the points in a cell, of a side: even cover gives 0.29; a line through it does not fix a plane.
constexpr double least_spread = 0.12;
constexpr double least_cosine = 0.15;  // a plane seen flatter than 81 degrees
// Noise along the normal. Range noise is 1 to 4 cm; more is foliage or an edge.
constexpr double most_noise_m = 0.06;
constexpr double noise_ratio = 2.5;  // to the median of all planes
constexpr double least_noise_m = 2e-3;
constexpr float inside_sigmas = 3.0F;
constexpr float usual_sigmas = 0.5F;  // by which a direction is off when the sensor moves by as much as matters

Vector3d on_face(int face, double depth, double x, double y) {
  const auto axis = static_cast<Eigen::Index>(face / 2);
  Vector3d p;
  p[axis] = face % 2 == 0 ? depth : -depth;
  p[(axis + 1) % 3] = x;
  p[(axis + 2) % 3] = y;
  return p;
}

double centre(std::int32_t index) { return (index + 0.5) / half_side - 1.0; }

}  // namespace

void RangeMotion::operator+=(const RangeMotion& other) {
  information += other.information;
  right += other.right;
  met += other.met;
  inside += other.inside;
  points += other.points;
}

RangePoint to_range_point(float x, float y, float z) {
  const float square = x * x + y * y + z * z;
  if (!(square > 1e-4F && square < 1e8F)) return {};  // also what is no number
  const std::array<float, 3> p = {x, y, z};
  std::size_t axis = std::abs(y) > std::abs(x) ? 1 : 0;
  if (std::abs(z) > std::abs(p[axis])) axis = 2;
  const float depth = std::abs(p[axis]);
  const float u = p[(axis + 1) % 3] / depth;
  const float v = p[(axis + 2) % 3] / depth;
  const auto index = [](float t) {
    return std::clamp(static_cast<int>((static_cast<double>(t) + 1.0) * half_side), 0, cells_a_side - 1);
  };
  const int face = 2 * static_cast<int>(axis) + (p[axis] < 0.0F ? 1 : 0);
  return {(face * cells_a_side + index(u)) * cells_a_side + index(v), u, v, depth};
}

RangePoint transformed(const SE3& T, const RangePoint& point) {
  if (point.cell < 0) return point;
  const int face = point.cell / cells_a_face;
  const Vector3d p = T * on_face(face, point.depth, point.depth * point.u, point.depth * point.v);
  return to_range_point(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
}

RangeReference::RangeReference()
    : plane_of_cell_(std::size_t{6} * cells_a_face, -1), sums_of_cell_(std::size_t{6} * cells_a_face, -1) {}

void RangeReference::build(std::span<const std::span<const RangePoint>> pieces) {
  for (const std::int32_t cell : cells_) {
    plane_of_cell_[static_cast<std::size_t>(cell)] = -1;
    sums_of_cell_[static_cast<std::size_t>(cell)] = -1;
  }
  cells_.clear();
  sums_.clear();
  planes_.clear();
  for (const std::span<const RangePoint> piece : pieces) {
    for (const RangePoint& point : piece) add(point);
  }
  for (std::size_t i = 0; i < cells_.size(); ++i) fit(cells_[i], sums_[i]);
  weigh();
}

void RangeReference::add(const RangePoint& point) {
  if (point.cell < 0) return;
  std::int32_t& index = sums_of_cell_[static_cast<std::size_t>(point.cell)];
  if (index < 0) {
    index = static_cast<std::int32_t>(sums_.size());
    sums_.emplace_back();
    cells_.push_back(point.cell);
  }
  Sums& s = sums_[static_cast<std::size_t>(index)];
  const double u = point.u;
  const double v = point.v;
  const double d = 1.0 / static_cast<double>(point.depth);
  s.n += 1.0;
  s.u += u;
  s.v += v;
  s.uu += u * u;
  s.uv += u * v;
  s.vv += v * v;
  s.d += d;
  s.du += d * u;
  s.dv += d * v;
  s.dd += d * d;
}

// d = a + b u + c v by least squares.
void RangeReference::fit(std::int32_t cell, const Sums& s) {
  if (s.n < fewest_points) return;
  const double mu = s.u / s.n;
  const double mv = s.v / s.n;
  const double md = s.d / s.n;
  const double uu = s.uu / s.n - mu * mu;
  const double uv = s.uv / s.n - mu * mv;
  const double vv = s.vv / s.n - mv * mv;
  const double du = s.du / s.n - md * mu;
  const double dv = s.dv / s.n - md * mv;
  const double dd = s.dd / s.n - md * md;
  const double least = least_spread / half_side;
  const double smaller = 0.5 * (uu + vv) - std::sqrt(0.25 * (uu - vv) * (uu - vv) + uv * uv);
  if (!(smaller > least * least)) return;
  const double determinant = uu * vv - uv * uv;
  const double b = (du * vv - dv * uv) / determinant;
  const double c = (dv * uu - du * uv) / determinant;
  const double a = md - b * mu - c * mv;
  const double left = std::max(0.0, dd - b * du - c * dv) * s.n / (s.n - 3.0);

  // m^T p = 1 on the plane.
  const int face = cell / cells_a_face;
  const Vector3d m = on_face(face, a, b, c);
  const double size = m.norm();
  const double u = centre(cell / cells_a_side % cells_a_side);
  const double v = centre(cell % cells_a_side);
  const double inverse_depth = a + b * u + c * v;
  const Vector3d ray = on_face(face, 1.0, u, v);
  if (!(size > 0.0) || inverse_depth <= 0.0 || inverse_depth < least_cosine * ray.norm() * size) return;
  const double noise = std::sqrt(left) / (inverse_depth * size);  // of the inverse depth, carried over to the normal
  if (!(noise <= most_noise_m)) return;
  const Vector3d point = ray / inverse_depth;
  Vector6d by_motion;  // p -> p + phi x p + tau
  by_motion << point.cross(m / size), m / size;
  plane_of_cell_[static_cast<std::size_t>(cell)] = static_cast<std::int32_t>(planes_.size());
  planes_.push_back({static_cast<float>(a), static_cast<float>(b), static_cast<float>(c),
                     static_cast<float>(1.0 / size), static_cast<float>(std::max(noise, least_noise_m)),
                     static_cast<float>(s.n), by_motion});
}

// Leaves out planes that are rougher than is usual here, and says what a point on the others is worth.
void RangeReference::weigh() {
  if (planes_.empty()) return;
  std::vector<float> noise;
  noise.reserve(planes_.size());
  for (const Plane& plane : planes_) noise.push_back(plane.noise);
  const float usual = median(std::move(noise));
  for (const std::int32_t cell : cells_) {
    std::int32_t& index = plane_of_cell_[static_cast<std::size_t>(cell)];
    if (index < 0) continue;
    Plane& plane = planes_[static_cast<std::size_t>(index)];
    if (plane.noise > static_cast<float>(noise_ratio) * usual) index = -1;
    // Few points often lie on a plane better than the noise is: mix with what is usual here.
    const float n = plane.weight;
    plane.noise = std::sqrt((n * plane.noise * plane.noise + 4.0F * usual * usual) / (n + 4.0F));
    plane.weight = n / (n + 4.0F);
  }
}

RangeMotion RangeReference::measure(std::span<const RangePoint> points) const {
  offsets_.assign(planes_.size(), Offset{});
  std::size_t usable = 0;
  std::size_t met = 0;
  std::size_t inside = 0;
  for (const RangePoint& point : points) {
    if (point.cell < 0) continue;
    ++usable;
    const std::int32_t index = plane_of_cell_[static_cast<std::size_t>(point.cell)];
    if (index < 0) continue;
    const Plane& plane = planes_[static_cast<std::size_t>(index)];
    const float off = (point.depth * (plane.a + plane.b * point.u + plane.c * point.v) - 1.0F) * plane.distance;
    const float sigmas = off / (inside_sigmas * plane.noise);
    const float robust = 1.0F / (1.0F + sigmas * sigmas);
    ++met;
    inside += sigmas * sigmas < 1.0F ? 1U : 0U;
    Offset& sum = offsets_[static_cast<std::size_t>(index)];
    sum.count += 1.0F;
    sum.weight += robust * robust;
    sum.weighted += robust * robust * off;
  }
  RangeMotion motion;
  motion.points = static_cast<double>(usable);
  motion.met = static_cast<double>(met);
  motion.inside = static_cast<double>(inside);
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    if (offsets_[i].weight <= 0.0F) continue;
    const Plane& plane = planes_[i];
    // The same for whole directions: what hides a wall there says nothing of the sensor's motion.
    const float mean = offsets_[i].weighted / offsets_[i].weight;
    const float far = mean / (plane.noise * (inside_sigmas / std::sqrt(offsets_[i].count) + usual_sigmas));
    const float robust = 1.0F / (1.0F + far * far);
    const double worth =
        static_cast<double>(plane.weight * robust * robust) / (static_cast<double>(plane.noise) * plane.noise);
    const Vector6d& j = plane.distance_by_motion;
    motion.information.triangularView<Eigen::Lower>() += (worth * offsets_[i].weight) * j * j.transpose();
    motion.right -= (worth * offsets_[i].weighted) * j;
  }
  motion.information.triangularView<Eigen::StrictlyUpper>() = motion.information.transpose();
  return motion;
}

}  // namespace rigcal
