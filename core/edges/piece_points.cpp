#include "core/edges/piece_points.h"

#include <algorithm>
#include <cmath>

#include "core/base/wide.h"

namespace rigcal {
namespace {

// The edge moves while its faces are fitted, though hardly so far.
constexpr double moves_m = 0.1;

// n.p = d from the middle of a piece.
struct NearPlane {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
  float d = 0.0F;

  NearPlane(const WorldPlane& plane, const Vector3d& middle)
      : x(static_cast<float>(plane.n.x())),
        y(static_cast<float>(plane.n.y())),
        z(static_cast<float>(plane.n.z())),
        d(static_cast<float>(plane.d - plane.n.dot(middle))) {}
};

struct NearGate {
  std::array<float, 3> p;
  std::array<float, 3> direction;
  float half_length;
  float reach2;
  NearPlane own;
  float own_m;
  NearPlane other;
  float other_m;
};

struct Places {
  const float* x;
  const float* y;
  const float* z;
  std::int32_t count;
};

// Takes the marks from places nearer to the plane than that.
RIGCAL_WIDE void unmark_near(const Places& places, const NearPlane& plane, float within, std::int32_t* marks) {
  const float* x = places.x;
  const float* y = places.y;
  const float* z = places.z;
  const NearPlane at = plane;
  const std::int32_t count = places.count;  // a mark might be it, as far as the compiler knows
  for (std::int32_t i = 0; i < count; ++i) {
    const float off = std::abs(at.x * x[i] + at.y * y[i] + at.z * z[i] - at.d);
    marks[i] &= static_cast<std::int32_t>(off >= within);
  }
}

// What tells where a point on a plane belongs.
struct Belonging {
  std::array<const float*, 3> ray;
  const float* across_share;
  const float* slant_growth;
  std::array<float*, 3> place;  // as it comes out
};

// Says of each place whether it passes, by where it belongs: p - (n.p - d) S n / n'S n with the point's covariance S,
// of which one part is along the ray, the other across it.
RIGCAL_WIDE void mark_passing(const Places& places, const Belonging& belonging, const NearGate& gate,
                              std::int32_t* marks) {
  const float* px = places.x;
  const float* py = places.y;
  const float* pz = places.z;
  const Belonging of = belonging;
  const NearGate at = gate;
  const std::int32_t count = places.count;
  RIGCAL_APART
  for (std::int32_t i = 0; i < count; ++i) {
    const float own = at.own.x * px[i] + at.own.y * py[i] + at.own.z * pz[i] - at.own.d;
    const float c = at.own.x * of.ray[0][i] + at.own.y * of.ray[1][i] + at.own.z * of.ray[2][i];
    const float growth = 1.0F + of.slant_growth[i] * (1.0F - std::abs(c));
    const float along_ray = growth * growth;
    const float across_ray = of.across_share[i];
    const float off = own / (along_ray * c * c + across_ray * (1.0F - c * c));
    const float by_ray = off * (along_ray - across_ray) * c;
    const float by_normal = off * across_ray;
    const float qx = px[i] - by_ray * of.ray[0][i] - by_normal * at.own.x;
    const float qy = py[i] - by_ray * of.ray[1][i] - by_normal * at.own.y;
    const float qz = pz[i] - by_ray * of.ray[2][i] - by_normal * at.own.z;
    of.place[0][i] = qx;
    of.place[1][i] = qy;
    of.place[2][i] = qz;
    const float x = qx - at.p[0];
    const float y = qy - at.p[1];
    const float z = qz - at.p[2];
    const float along = at.direction[0] * x + at.direction[1] * y + at.direction[2] * z;
    const float across2 = x * x + y * y + z * z - along * along;
    const float other = std::abs(at.other.x * qx + at.other.y * qy + at.other.z * qz - at.other.d);
    marks[i] = static_cast<std::int32_t>(std::abs(along) <= at.half_length) &
               static_cast<std::int32_t>(across2 <= at.reach2) & static_cast<std::int32_t>(std::abs(own) <= at.own_m) &
               static_cast<std::int32_t>(other >= at.other_m);
  }
}

std::array<float, 3> floats(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

void PiecePoints::take(const EdgePiece& piece, const EdgePoints& points, const std::vector<NoiseModel>& noise,
                       double radius_m, double apart_m) {
  middle_ = piece.middle;
  largest_range_m_ = 0.0;
  cubes_.clear();
  points_.clear();
  for (std::vector<float>& axis : from_middle_) axis.clear();
  for (std::vector<float>& axis : rays_) axis.clear();
  others_.clear();
  points.around(piece.middle, radius_m, cubes_);
  const double farthest_m = radius_m + moves_m;
  const auto farthest2 = static_cast<float>(farthest_m * farthest_m);
  for (const std::span<const EdgePoint>& cube : cubes_) {
    for (const EdgePoint& point : cube) {
      const Eigen::Vector3f d = (point.p_G.cast<double>() - middle_).cast<float>();
      if (d.squaredNorm() > farthest2) continue;
      points_.push_back(&point);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        from_middle_[axis].push_back(d[static_cast<Eigen::Index>(axis)]);
        rays_[axis].push_back(point.ray_G[static_cast<Eigen::Index>(axis)]);
      }
    }
  }
  marks_.assign(points_.size(), 1);
  const Places places{from_middle_[0].data(), from_middle_[1].data(), from_middle_[2].data(),
                      static_cast<std::int32_t>(points_.size())};
  for (const WorldPlane& other : piece.others) {
    // Most are too far away to hold any.
    if (std::abs(other.distance(middle_)) > farthest_m + apart_m) continue;
    others_.push_back(other);
    unmark_near(places, NearPlane(other, middle_), static_cast<float>(apart_m), marks_.data());
  }
  keep_marked();
  across_share_.clear();
  slant_growth_.clear();
  for (const EdgePoint* point : points_) {
    const NoiseModel& of = noise[point->lidar];
    const double range2 = std::pow(static_cast<double>(point->range_m), 2);
    across_share_.push_back(
        static_cast<float>(of.angle_rad * of.angle_rad * range2 / std::max(of.range_variance(range2, 1.0), 1e-12)));
    slant_growth_.push_back(static_cast<float>(of.slant_growth));
  }
}

void PiecePoints::keep_marked() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (marks_[i] == 0) continue;
    points_[kept] = points_[i];
    for (std::vector<float>& axis : from_middle_) axis[kept] = axis[i];
    for (std::vector<float>& axis : rays_) axis[kept] = axis[i];
    largest_range_m_ = std::max(largest_range_m_, static_cast<double>(points_[i]->range_m));
    ++kept;
  }
  points_.resize(kept);
  for (std::vector<float>& axis : from_middle_) axis.resize(kept);
  for (std::vector<float>& axis : rays_) axis.resize(kept);
}

void PiecePoints::choose(const FaceGate& gate, std::vector<std::uint32_t>& chosen) {
  chosen.clear();
  const Places places{from_middle_[0].data(), from_middle_[1].data(), from_middle_[2].data(),
                      static_cast<std::int32_t>(points_.size())};
  for (std::vector<float>& axis : on_plane_) axis.resize(points_.size());
  const Belonging belonging{{rays_[0].data(), rays_[1].data(), rays_[2].data()},
                            across_share_.data(),
                            slant_growth_.data(),
                            {on_plane_[0].data(), on_plane_[1].data(), on_plane_[2].data()}};
  const NearGate near{floats(gate.line.p - middle_),          floats(gate.line.direction),
                      static_cast<float>(gate.half_length_m), static_cast<float>(gate.reach_m * gate.reach_m),
                      NearPlane(gate.own, middle_),           static_cast<float>(gate.own_m),
                      NearPlane(gate.other, middle_),         static_cast<float>(gate.border_m)};
  mark_passing(places, belonging, near, marks_.data());
  const Places on_plane{on_plane_[0].data(), on_plane_[1].data(), on_plane_[2].data(), places.count};
  for (const WorldPlane& other : others_)
    unmark_near(on_plane, NearPlane(other, middle_), static_cast<float>(gate.border_m), marks_.data());
  for (std::uint32_t i = 0; i < points_.size(); ++i) {
    if (marks_[i] != 0) chosen.push_back(i);
  }
}

}  // namespace rigcal
