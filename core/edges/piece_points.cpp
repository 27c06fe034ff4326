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

// Sets the marks of places nearer to the plane than that.
RIGCAL_WIDE void mark_near(const Places& places, const NearPlane& plane, float within, std::int32_t* marks) {
  const float* x = places.x;
  const float* y = places.y;
  const float* z = places.z;
  const NearPlane at = plane;
  for (std::int32_t i = 0; i < places.count; ++i) {
    const float off = std::abs(at.x * x[i] + at.y * y[i] + at.z * z[i] - at.d);
    marks[i] |= static_cast<std::int32_t>(off < within);
  }
}

// Says of each place whether it passes.
RIGCAL_WIDE void mark_passing(const Places& places, const NearGate& gate, std::int32_t* marks) {
  const float* px = places.x;
  const float* py = places.y;
  const float* pz = places.z;
  const NearGate at = gate;
  for (std::int32_t i = 0; i < places.count; ++i) {
    const float x = px[i] - at.p[0];
    const float y = py[i] - at.p[1];
    const float z = pz[i] - at.p[2];
    const float along = at.direction[0] * x + at.direction[1] * y + at.direction[2] * z;
    const float across2 = x * x + y * y + z * z - along * along;
    const float own = std::abs(at.own.x * px[i] + at.own.y * py[i] + at.own.z * pz[i] - at.own.d);
    const float other = std::abs(at.other.x * px[i] + at.other.y * py[i] + at.other.z * pz[i] - at.other.d);
    marks[i] = static_cast<std::int32_t>(std::abs(along) <= at.half_length) &
               static_cast<std::int32_t>(across2 <= at.reach2) & static_cast<std::int32_t>(own <= at.own_m) &
               static_cast<std::int32_t>(other >= at.other_m);
  }
}

std::array<float, 3> floats(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

void PiecePoints::take(const EdgePiece& piece, const EdgePoints& points, double radius_m, double apart_m) {
  middle_ = piece.middle;
  largest_range_m_ = 0.0;
  cubes_.clear();
  points_.clear();
  for (std::vector<float>& axis : from_middle_) axis.clear();
  points.around(piece.middle, radius_m, cubes_);
  const double farthest_m = radius_m + moves_m;
  const auto farthest2 = static_cast<float>(farthest_m * farthest_m);
  for (const std::span<const EdgePoint>& cube : cubes_) {
    for (const EdgePoint& point : cube) {
      const Eigen::Vector3f d = (point.p_G.cast<double>() - middle_).cast<float>();
      if (d.squaredNorm() > farthest2) continue;
      points_.push_back(&point);
      for (std::size_t axis = 0; axis < 3; ++axis) from_middle_[axis].push_back(d[static_cast<Eigen::Index>(axis)]);
    }
  }
  marks_.assign(points_.size(), 0);
  const Places places{from_middle_[0].data(), from_middle_[1].data(), from_middle_[2].data(),
                      static_cast<std::int32_t>(points_.size())};
  for (const WorldPlane& other : piece.others) {
    // Most are too far away to hold any.
    if (std::abs(other.distance(middle_)) > farthest_m + apart_m) continue;
    mark_near(places, NearPlane(other, middle_), static_cast<float>(apart_m), marks_.data());
  }
  keep_unmarked();
}

void PiecePoints::keep_unmarked() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (marks_[i] != 0) continue;
    points_[kept] = points_[i];
    for (std::vector<float>& axis : from_middle_) axis[kept] = axis[i];
    largest_range_m_ = std::max(largest_range_m_, static_cast<double>(points_[i]->range_m));
    ++kept;
  }
  points_.resize(kept);
  for (std::vector<float>& axis : from_middle_) axis.resize(kept);
}

void PiecePoints::choose(const FaceGate& gate, std::vector<std::uint32_t>& chosen) {
  chosen.clear();
  const Places places{from_middle_[0].data(), from_middle_[1].data(), from_middle_[2].data(),
                      static_cast<std::int32_t>(points_.size())};
  const NearGate near{floats(gate.line.p - middle_),          floats(gate.line.direction),
                      static_cast<float>(gate.half_length_m), static_cast<float>(gate.reach_m * gate.reach_m),
                      NearPlane(gate.own, middle_),           static_cast<float>(gate.own_m),
                      NearPlane(gate.other, middle_),         static_cast<float>(gate.other_m)};
  mark_passing(places, near, marks_.data());
  for (std::uint32_t i = 0; i < points_.size(); ++i) {
    if (marks_[i] != 0) chosen.push_back(i);
  }
}

}  // namespace rigcal
