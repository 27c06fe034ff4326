#include "core/planes/refine.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <stop_token>
#include <utility>

#include "core/base/parallel.h"
#include "core/geometry/matrix6.h"
#include "tests/support/leaves_from_two_stops.h"
#include "tests/support/make_cells.h"
#include "tests/support/make_planes.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

// A room seen by two LiDARs from six stops of a full turn.
struct Room {
  RigState truth = turning_rig(6, Vector3d(0.25, 0.1, 0.0));
  std::vector<PatchCells> patches;
  std::vector<NoiseModel> noise;
  ParameterLayout layout{6, 2};

  // Turned against the walls: a wall that lies in a face of the grid is shared out between two voxels by its noise.
  SE3 T_grid_G{exp_so3(Vector3d(0.3, 0.2, 0.5)), Vector3d(0.5, 0.7, 0.9)};

  explicit Room(std::uint64_t seed) {
    Random random(seed);
    noise.assign(2, NoiseModel{0.01, 0.0, 0.0005});
    patches = make_patches(make_room(), truth, View{300.0, to_rad(60.0), noise[0]}, random);
    for (int j = 1; j < 6; ++j) layout.free_stop(j);
    layout.free_lidar(1);
  }
};

// Every free pose off by exactly so much in a random direction.
RigState spoiled(const RigState& truth, double rotation_rad, double translation_m, Random& random) {
  const auto off = [&](const SE3& T) {
    const SE3 direction = random_pose(random, 1.0, 1.0);
    return T * SE3{exp_so3(rotation_rad * log_so3(direction.R).normalized()), translation_m * direction.t.normalized()};
  };
  RigState out = truth;
  for (std::size_t j = 1; j < out.T_G_base.size(); ++j) out.T_G_base[j] = off(out.T_G_base[j]);
  for (std::size_t i = 1; i < out.T_base_sensor.size(); ++i) out.T_base_sensor[i] = off(out.T_base_sensor[i]);
  return out;
}

Expected<RefineSummary> refined(const Room& room, int tight, RigState& state) {
  SilentReporter reporter;
  return refine({room.patches, room.noise, room.T_grid_G, {}, {}}, room.layout, standard_passes(tight),
                RunContext{reporter}, state);
}

TEST(Refine, FindsPosesAndExtrinsicsOfARoomFromFiveCentimetresAndADegree) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Room room(seed);
    Random random(100 + seed);
    RigState state = spoiled(room.truth, to_rad(1.0), 0.05, random);
    const auto summary = refined(room, 4, state);
    ASSERT_TRUE(summary.has_value());
    EXPECT_LE(summary->cost_after, summary->cost_before);
    for (const ExtrinsicMove& move : summary->last_moves) EXPECT_LT(move.translation_m, 3e-4);
    // Sigma of the extrinsic is 0.4 mm and 0.008 degrees, of a pose some less.
    for (std::size_t j = 1; j < 6; ++j) EXPECT_THAT(state.T_G_base[j], SE3Near(room.truth.T_G_base[j], 0.03, 1.0));
    EXPECT_THAT(state.T_base_sensor[1], SE3Near(room.truth.T_base_sensor[1], 0.03, 1.0));
    EXPECT_EQ(state.T_G_base[0].t, room.truth.T_G_base[0].t);
    EXPECT_EQ(state.T_base_sensor[0].R, room.truth.T_base_sensor[0].R);
  }
}

// How far one step from the truth ends from the optimum of the map there.
double left_after_one_step(const Room& room, HessianForm form) {
  RefinePass pass = standard_passes(1).back();
  pass.iterations = 1;
  pass.form = form;
  RigState state = room.truth;
  SilentReporter reporter;
  const auto summary =
      refine({room.patches, room.noise, room.T_grid_G, {}, {}}, room.layout, {pass}, RunContext{reporter}, state);
  EXPECT_TRUE(summary.has_value());
  RigState optimum = state;
  AdjustOptions to_the_end;
  to_the_end.form = HessianForm::exact;
  adjust(summary->map.features, room.layout, to_the_end, optimum);
  return (optimum.T_base_sensor[1].t - state.T_base_sensor[1].t).norm();
}

TEST(Refine, TightPassesTakeTheExactHessianWhichLeavesTheSquareOfAStep) {
  EXPECT_EQ(standard_passes(1).front().form, HessianForm::gauss_newton);
  EXPECT_EQ(standard_passes(1).back().form, HessianForm::exact);
  const Room room(71);
  EXPECT_LT(left_after_one_step(room, HessianForm::exact), 0.4 * left_after_one_step(room, HessianForm::gauss_newton));
}

TEST(Refine, ErrorsOfTheExtrinsicScatterAsTheInverseHessianSays) {
  double nees = 0.0;
  constexpr int draws = 8;
  for (int draw = 0; draw < draws; ++draw) {
    const Room room(200 + static_cast<std::uint64_t>(draw));
    RigState state = room.truth;
    const auto summary = refined(room, 2, state);
    ASSERT_TRUE(summary.has_value());
    const auto sum = build_normal_equations(summary->map.features, state, room.layout, HessianForm::gauss_newton);
    const Matrix6d covariance = (2.0 * sum.H.inverse()).bottomRightCorner<6, 6>();
    const Vector6d e = (room.truth.T_base_sensor[1].inverse() * state.T_base_sensor[1]).log();
    nees += e.dot(solve_symmetric6(covariance, e)) / draws;
  }
  // Mean 6, its standard error sqrt(12 / 8) = 1.2; the weights' floor of 1 mm makes it a little less.
  EXPECT_NEAR(6.0, nees, 3.0 * 1.2);
}

TEST(Refine, IsTheSameToTheBitForOneAndTwoThreads) {
  const Room room(31);
  Random random(32);
  RigState one = spoiled(room.truth, to_rad(0.5), 0.03, random);
  RigState two = one;
  set_thread_count(1);
  ASSERT_TRUE(refined(room, 1, one).has_value());
  set_thread_count(2);
  ASSERT_TRUE(refined(room, 1, two).has_value());
  for (std::size_t j = 0; j < 6; ++j) {
    EXPECT_EQ(one.T_G_base[j].R, two.T_G_base[j].R);
    EXPECT_EQ(one.T_G_base[j].t, two.T_G_base[j].t);
  }
  EXPECT_EQ(one.T_base_sensor[1].R, two.T_base_sensor[1].R);
  EXPECT_EQ(one.T_base_sensor[1].t, two.T_base_sensor[1].t);
}

// From the truth, in the grid of the room and in one that is turned and shifted against it.
struct InTwoGrids {
  std::array<RigState, 2> rest;  // where the passes end
  std::array<RigState, 2> evened;
};

InTwoGrids in_two_grids(const Room& room) {
  InTwoGrids out;
  const std::array<SE3, 2> grids{room.T_grid_G,
                                 SE3{exp_so3(Vector3d(-0.4, 0.1, 0.3)), Vector3d(0.13, 0.05, 0.31)} * room.T_grid_G};
  for (std::size_t k = 0; k < 2; ++k) {
    SilentReporter reporter;
    const RefineInput input{room.patches, room.noise, grids[k], {}, {}};
    const std::vector<RefinePass> passes = standard_passes(3);
    RigState state = room.truth;
    const auto summary = refine(input, room.layout, passes, RunContext{reporter}, state);
    EXPECT_TRUE(summary.has_value());
    out.rest[k] = state;
    EXPECT_TRUE(
        adjust_over_grids(input, room.layout, passes.back(), 3, summary->map, RunContext{reporter}, state).has_value());
    out.evened[k] = state;
  }
  return out;
}

TEST(AdjustOverGrids, TakesAwayMuchOfWhatTheGridDecides) {
  double rest = 0.0;
  double evened = 0.0;
  for (std::uint64_t seed = 41; seed <= 56; ++seed) {
    const InTwoGrids found = in_two_grids(Room(seed));
    const auto apart2 = [](const std::array<RigState, 2>& two) {
      return (two[0].T_base_sensor[1].t - two[1].T_base_sensor[1].t).squaredNorm();
    };
    rest += apart2(found.rest);
    evened += apart2(found.evened);
  }
  // A third of the square is what three grids of their own would leave; those of one family share something.
  EXPECT_LT(evened, 0.6 * rest);
}

TEST(AdjustOverGrids, WithOneGridMovesNothingThatIsAtRest) {
  const Room room(61);
  SilentReporter reporter;
  const RefineInput input{room.patches, room.noise, room.T_grid_G, {}, {}};
  const std::vector<RefinePass> passes = standard_passes(3);
  RigState state = room.truth;
  const auto summary = refine(input, room.layout, passes, RunContext{reporter}, state);
  ASSERT_TRUE(summary.has_value());
  const RigState rest = state;
  ASSERT_TRUE(
      adjust_over_grids(input, room.layout, passes.back(), 1, summary->map, RunContext{reporter}, state).has_value());
  EXPECT_LT((state.T_base_sensor[1].t - rest.T_base_sensor[1].t).norm(), 4e-6);  // twice what ends a pass
}

TEST(Refine, SettlesByPassesOverThreeGridsAfterTheTightOnes) {
  const std::vector<RefinePass> passes = standard_passes(2, 3);
  ASSERT_EQ(passes.size(), 7U);
  for (std::size_t k = 0; k < passes.size(); ++k) EXPECT_EQ(passes[k].grids, k < 4 ? 1 : 3) << k;
  EXPECT_EQ(passes.back().form, HessianForm::exact);
  const Room room(63);
  SilentReporter reporter;
  const RefineInput input{room.patches, room.noise, room.T_grid_G, {}, {}};
  RigState rest = room.truth;
  ASSERT_TRUE(refine(input, room.layout, standard_passes(3), RunContext{reporter}, rest).has_value());
  RigState settled = rest;
  const auto summary = refine(input, room.layout, {passes.back()}, RunContext{reporter}, settled);
  ASSERT_TRUE(summary.has_value());
  RigState evened = rest;
  ASSERT_TRUE(
      adjust_over_grids(input, room.layout, passes.back(), 3, summary->map, RunContext{reporter}, evened).has_value());
  EXPECT_EQ(settled.T_base_sensor[1].t, evened.T_base_sensor[1].t);
  EXPECT_EQ(summary->last_moves[1].translation_m,
            (rest.T_base_sensor[1].inverse() * settled.T_base_sensor[1]).t.norm());
  EXPECT_GT(summary->last_moves[1].translation_m, 0.0);
}

TEST(AdjustOverGrids, StopsWhenToldTo) {
  const Room room(62);
  SilentReporter reporter;
  std::stop_source stop;
  stop.request_stop();
  RigState state = room.truth;
  const auto done = adjust_over_grids({room.patches, room.noise, room.T_grid_G, {}, {}}, room.layout,
                                      standard_passes(1).back(), 3, PlaneMap{}, {reporter, stop.get_token()}, state);
  ASSERT_FALSE(done.has_value());
  EXPECT_EQ(ErrorKind::cancelled, done.error().kind);
}

TEST(Refine, StopsWhenToldTo) {
  const Room room(33);
  RigState state = room.truth;
  SilentReporter reporter;
  std::stop_source stop;
  stop.request_stop();
  const auto summary = refine({room.patches, room.noise, {}, {}, {}}, room.layout, standard_passes(1),
                              RunContext{reporter, stop.get_token()}, state);
  ASSERT_FALSE(summary.has_value());
  EXPECT_EQ(ErrorKind::cancelled, summary.error().kind);
}

// Normals of a house: floor and ceiling strongest, then the long walls, then the short ones, and clutter; of either
// sign and bent by half a degree.
struct House {
  std::vector<Vector3d> normals;
  std::vector<Vector3d> centers;
  std::vector<double> weights;

  explicit House(Random& random) {
    const auto add = [&](const Vector3d& n, int count, double weight) {
      for (int i = 0; i < count; ++i) {
        const double sign = random.uniform() < 0.5 ? -1.0 : 1.0;
        normals.push_back(sign * (random_pose(random, to_rad(0.5), 0.0).R * n));
        centers.push_back(random_pose(random, 0.0, 3.0).t);
        weights.push_back(weight * random.uniform(0.5, 1.5));
      }
    };
    add(Vector3d::UnitZ(), 300, 1.0);
    add(Vector3d::UnitX(), 150, 1.2);
    add(Vector3d::UnitY(), 200, 0.6);
    for (int i = 0; i < 100; ++i) add(random_pose(random, 2.0, 0.0).R.col(0), 1, 0.5);
  }
};

double axis_angle_deg(const Vector3d& a, const Vector3d& b) { return to_deg(std::asin(a.cross(b).norm())); }

TEST(UnexplainedOffset, GoesByLeavesOfTheSizeAskedFor) {
  const RigState state = state_of_two_stops();
  PlaneMap map;
  add_leaves(1.0, 0.0002, 1e-6, map);
  EXPECT_EQ(unexplained_offset(map, state, 0.0), 0.0) << "less than noise";
  for (int k = 0; k < 3; ++k) add_leaves(0.25, 0.004, 1e-6, map);
  // Squares over half a freedom, by the median of a squared normal variable, and the noise's millimetre.
  EXPECT_NEAR(unexplained_offset(map, state, 0.0), std::sqrt(2.0 * 16e-6 / 0.455 - 1e-6), 1e-5);
  EXPECT_EQ(unexplained_offset(map, state, 0.0, 0.5), 0.0);
}

TEST(GridFrame, HasItsAxesAlongTheStrongestNormalsAndItsOriginInTheMiddle) {
  Random random(41);
  const House house(random);
  const SE3 T_grid_G = grid_frame(house.normals, house.centers, house.weights);
  // Hundreds of normals bent by half a degree: their mean is good to 0.05, clutter within ten degrees pulls some more.
  EXPECT_LT(axis_angle_deg(T_grid_G.R.row(2), Vector3d::UnitZ()), 0.3);
  EXPECT_LT(axis_angle_deg(T_grid_G.R.row(0), Vector3d::UnitX()), 0.3);
  EXPECT_LT((T_grid_G.R * T_grid_G.R.transpose() - Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(1.0, T_grid_G.R.determinant(), 1e-12);
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < house.centers.size(); ++i) sum += house.weights[i] * (T_grid_G * house.centers[i]);
  EXPECT_LT(sum.norm(), 1e-9);
}

TEST(GridFrame, TurnsAlongWithTheWorld) {
  Random random(42);
  House house(random);
  const SE3 before = grid_frame(house.normals, house.centers, house.weights);
  const SE3 T_new_old = random_pose(random, 1.0, 5.0);
  for (Vector3d& n : house.normals) n = T_new_old.R * n;
  for (Vector3d& c : house.centers) c = T_new_old * c;
  const SE3 after = grid_frame(house.normals, house.centers, house.weights) * T_new_old;
  EXPECT_THAT(after, SE3Near(before, 1e-9, 1e-9));
}

TEST(GridFrame, HardlyDependsOnTheOrderOfThePlanes) {
  Random random(43);
  House house(random);
  const SE3 before = grid_frame(house.normals, house.centers, house.weights);
  for (std::size_t i = house.normals.size() - 1; i > 0; --i) {
    const std::size_t k = random.below(i + 1);
    std::swap(house.normals[i], house.normals[k]);
    std::swap(house.centers[i], house.centers[k]);
    std::swap(house.weights[i], house.weights[k]);
  }
  const SE3 after = grid_frame(house.normals, house.centers, house.weights);
  // Another one of the strongest bundle stands for it: its ten degrees hold a little more or less clutter.
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_LT(axis_angle_deg(before.R.row(axis), after.R.row(axis)), 0.2) << "axis " << axis;
  // The same grid but for the signs of its axes: voxels are mirrored onto voxels, the origin stays.
  const Vector3d origin_before = before.inverse().t;
  EXPECT_LT((origin_before - after.inverse().t).norm(), 1e-9);
}

TEST(GridFrame, OfNothingIsTheWorldAndOfOneNormalStillAFrame) {
  EXPECT_THAT(grid_frame({}, {}, {}), SE3Near(SE3{}, 0.0, 0.0));
  const Vector3d n = Vector3d(1.0, 2.0, 3.0).normalized();
  const SE3 one = grid_frame({n}, {Vector3d(1.0, 1.0, 1.0)}, {2.0});
  EXPECT_LT(axis_angle_deg(one.R.row(2), n), 1e-6);
  EXPECT_LT((one.R * one.R.transpose() - Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT((one * Vector3d(1.0, 1.0, 1.0)).norm(), 1e-12);
}

}  // namespace
}  // namespace rigcal
