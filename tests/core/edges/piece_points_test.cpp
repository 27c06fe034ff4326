#include "core/edges/piece_points.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/random.h"

namespace rigcal {
namespace {

// A corner of a room at (5, 2, 0), seen by two LiDARs: the wall x = 5 goes on to y < 2, the wall y = 2 to x < 5, and
// the ceiling z = 0.4 ends both. Points lie off their walls by far more than noise, so that all gates are tried.
struct Corner {
  Corner() {
    piece.middle = {5.0, 2.0, 0.0};
    piece.direction = Vector3d::UnitZ();
    piece.a = {Vector3d::UnitX(), 5.0};
    piece.b = {Vector3d::UnitY(), 2.0};
    piece.others = {{Vector3d::UnitZ(), 0.4}};
    state.T_G_base = {SE3{}};
    state.T_base_sensor = {SE3{exp_so3({0.1, -0.2, 0.3}), {0.3, -0.4, 0.2}},
                           SE3{exp_so3({-0.3, 0.2, 2.0}), {-1.0, 1.5, -0.3}}};
    Random random(7);
    for (int lidar = 0; lidar < 2; ++lidar) {
      PatchCells& patch = patches.emplace_back();
      patch.lidar = lidar;
      const SE3 T_sensor_G = state.T_base_sensor[static_cast<std::size_t>(lidar)].inverse();
      for (int i = 0; i < 4000; ++i) {
        const double along = random.uniform(-0.6, 0.6);
        const double across = random.uniform(-0.5, 0.1);
        const double off = random.uniform(-0.08, 0.08);
        const Vector3d p_G =
            i % 2 == 0 ? Vector3d(5.0 + off, 2.0 + across, along) : Vector3d(5.0 + across, 2.0 + off, along);
        const Vector3d p = T_sensor_G * p_G;
        Point& point = patch.thinned.emplace_back();
        point.x = static_cast<float>(p.x());
        point.y = static_cast<float>(p.y());
        point.z = static_cast<float>(p.z());
      }
    }
  }

  [[nodiscard]] FaceGate gate() const {
    FaceGate gate;
    gate.line = {{5.0, 2.0, 0.0}, Vector3d::UnitZ()};
    gate.half_length_m = 0.2;
    gate.reach_m = 0.35;
    gate.own = piece.a;
    gate.own_m = 0.05;
    gate.other = piece.b;
    gate.border_m = 0.09;
    return gate;
  }

  EdgePiece piece;
  RigState state;
  std::vector<PatchCells> patches;
  std::vector<NoiseModel> noise{{0.01, 0.0, 0.0004, 0.5}, {0.02, 0.001, 0.003, 0.0}};
};

constexpr double radius_m = 0.45;
constexpr double apart_m = 0.06;
constexpr double rounding_m = 1e-5;

// By how much a point is inside the gates; negative: outside. From the formula, in doubles.
double inside_m(const EdgePoint& point, const FaceGate& gate, const Corner& corner) {
  const Vector3d p = point.p_G.cast<double>();
  const Vector3d n = gate.own.n;
  const Vector3d from_sensor = static_cast<double>(point.range_m) * point.ray_G.cast<double>();
  const Vector3d Sn = corner.noise[point.lidar].point_covariance(from_sensor, n) * n;
  const Vector3d q = p - gate.own.distance(p) / n.dot(Sn) * Sn;
  const double along = gate.line.direction.dot(q - gate.line.p);
  const double across = (q - gate.line.p - along * gate.line.direction).norm();
  double inside =
      std::min({gate.half_length_m - std::abs(along), gate.reach_m - across,
                gate.own_m - std::abs(gate.own.distance(p)), std::abs(gate.other.distance(q)) - gate.border_m});
  for (const WorldPlane& other : corner.piece.others) {
    inside = std::min({inside, std::abs(other.distance(p)) - apart_m, std::abs(other.distance(q)) - gate.border_m});
  }
  return inside;
}

TEST(PiecePoints, AreChosenByWhereTheyBelongOnTheFace) {
  const Corner corner;
  const EdgePoints all({corner.piece}, corner.patches, corner.state, {}, radius_m);
  std::vector<std::span<const EdgePoint>> cubes;
  all.around(corner.piece.middle, radius_m, cubes);
  PiecePoints points;
  points.take(corner.piece, all, corner.noise, radius_m, apart_m);
  for (const double tilt : {0.0, 0.15}) {
    FaceGate gate = corner.gate();
    gate.own.n = (gate.own.n + tilt * Vector3d(0.0, 1.0, 0.5)).normalized();
    gate.own.d = gate.own.n.dot(gate.line.p);
    std::vector<std::uint32_t> chosen;
    points.choose(gate, chosen);
    std::set<const EdgePoint*> is_chosen;
    for (const std::uint32_t i : chosen) is_chosen.insert(&points[i]);
    EXPECT_EQ(is_chosen.size(), chosen.size());
    std::size_t passing = 0;
    for (const std::span<const EdgePoint>& cube : cubes) {
      for (const EdgePoint& point : cube) {
        const double inside = inside_m(point, gate, corner);
        if (std::abs(inside) < rounding_m) continue;
        EXPECT_EQ(is_chosen.contains(&point), inside > 0.0) << point.p_G.transpose() << ", inside by " << inside;
        passing += inside > 0.0 ? 1 : 0;
      }
    }
    EXPECT_GT(passing, 300U);
  }
}

TEST(PiecePoints, OfAThirdPlaneAreNotTaken) {
  const Corner corner;
  const EdgePoints all({corner.piece}, corner.patches, corner.state, {}, radius_m);
  PiecePoints points;
  points.take(corner.piece, all, corner.noise, radius_m, apart_m);
  ASSERT_GT(points.size(), 1000U);
  double largest_m = 0.0;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    EXPECT_GT(std::abs(points[i].p_G.z() - 0.4F), 0.06F - 1e-5F);
    largest_m = std::max(largest_m, static_cast<double>(points[i].range_m));
  }
  EXPECT_EQ(points.largest_range_m(), largest_m);
}

TEST(PiecePoints, CanBeTakenForAnotherPieceAfterwards) {
  const Corner corner;
  EdgePiece above = corner.piece;
  above.middle.z() = 0.2;
  const EdgePoints all({corner.piece, above}, corner.patches, corner.state, {}, radius_m);
  PiecePoints used;
  used.take(above, all, corner.noise, radius_m, apart_m);
  std::vector<std::uint32_t> chosen;
  used.choose(corner.gate(), chosen);
  used.take(corner.piece, all, corner.noise, radius_m, apart_m);
  used.choose(corner.gate(), chosen);
  PiecePoints fresh;
  fresh.take(corner.piece, all, corner.noise, radius_m, apart_m);
  std::vector<std::uint32_t> chosen_by_fresh;
  fresh.choose(corner.gate(), chosen_by_fresh);
  EXPECT_EQ(used.size(), fresh.size());
  EXPECT_EQ(chosen, chosen_by_fresh);
}

}  // namespace
}  // namespace rigcal
