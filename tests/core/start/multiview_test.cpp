#include "core/start/multiview.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/parallel.h"
#include "tests/support/make_cells.h"
#include "tests/support/make_planes.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

constexpr int stops = 6;

struct Room {
  RigState truth = turning_rig(stops, Vector3d(0.25, 0.1, 0.0));
  std::vector<PatchSurfels> patches;
  ParameterLayout layout{stops, 2};

  explicit Room(std::uint64_t seed) {
    Random random(seed);
    patches = extract_surfels(make_patches(make_room(), truth, View{120.0, to_rad(60.0), {0.02, 0.0, 0.0005}}, random),
                              SurfelOptions{});
    for (int j = 1; j < stops; ++j) layout.free_stop(j);
    layout.free_lidar(1);
  }
};

TEST(AlignSurfels, LaysAllPatchesOnEachOther) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Room room(seed);
    Random random(100 + seed);
    RigState state = disturbed(room.truth, random, to_rad(1.0), 0.05);
    align_surfels(room.patches, room.layout, {}, state);
    // A centimetre is what it promises; over the three metres to the walls that is 0.2 degrees.
    for (std::size_t j = 0; j < stops; ++j) EXPECT_THAT(state.T_G_base[j], SE3Near(room.truth.T_G_base[j], 0.3, 10.0));
    EXPECT_THAT(state.T_base_sensor[1], SE3Near(room.truth.T_base_sensor[1], 0.3, 10.0));
    EXPECT_EQ(room.truth.T_G_base[0].t, state.T_G_base[0].t);
    EXPECT_EQ(room.truth.T_base_sensor[0].R, state.T_base_sensor[0].R);
  }
}

TEST(AlignSurfels, HoldsAStopWithoutSurfelsAtItsPrior) {
  Room room(11);
  std::erase_if(room.patches, [](const PatchSurfels& p) { return p.stop == 3; });
  Random random(12);
  RigState state = disturbed(room.truth, random, to_rad(0.5), 0.03);
  const SE3 unseen = state.T_G_base[3];
  MultiviewOptions options;
  options.priors.stop_priors.resize(stops);
  options.priors.stop_priors[3] = isotropic_prior(unseen, to_rad(1.0), 0.1);
  align_surfels(room.patches, room.layout, options, state);
  EXPECT_THAT(state.T_G_base[3], SE3Near(unseen, 1e-6, 1e-4));
  EXPECT_THAT(state.T_G_base[4], SE3Near(room.truth.T_G_base[4], 0.3, 10.0));
}

TEST(AlignSurfels, LeavesTheStateAloneWhereNothingIsFreeOrSeen) {
  const Room room(13);
  Random random(14);
  const RigState before = disturbed(room.truth, random, to_rad(0.5), 0.03);
  RigState state = before;
  align_surfels(room.patches, ParameterLayout(stops, 2), {}, state);
  align_surfels({}, room.layout, {}, state);
  for (std::size_t j = 0; j < stops; ++j) EXPECT_THAT(state.T_G_base[j], SE3Near(before.T_G_base[j], 1e-9, 1e-9));
}

// Four LiDARs at 80, 500 and 1000 stops: a matrix for each sum, all of them at once.
TEST(AlignSurfels, TakesNoMoreMemoryThanTheUnknownsNeed) {
  EXPECT_EQ(pairs_at_a_time(400'000, 492), 16384U);
  EXPECT_EQ(pairs_at_a_time(0, 6), 16384U);
  constexpr std::size_t pairs = 2'400'000;
  const auto sums = [](std::size_t unknowns) {
    const std::size_t each = pairs_at_a_time(pairs, unknowns);
    return (pairs + each - 1) / each;
  };
  EXPECT_LE(sums(3012) * 3012 * 3012 * sizeof(double), std::size_t{512} << 20U);
  EXPECT_GE(sums(3012), 4U);
  EXPECT_EQ(sums(6012), 4U);
}

TEST(AlignSurfels, IsTheSameToTheBitForOneAndTwoThreads) {
  const Room room(15);
  Random random(16);
  RigState one = disturbed(room.truth, random, to_rad(0.5), 0.03);
  RigState two = one;
  set_thread_count(1);
  align_surfels(room.patches, room.layout, {}, one);
  set_thread_count(2);
  align_surfels(room.patches, room.layout, {}, two);
  for (std::size_t j = 0; j < stops; ++j) {
    EXPECT_EQ(one.T_G_base[j].R, two.T_G_base[j].R);
    EXPECT_EQ(one.T_G_base[j].t, two.T_G_base[j].t);
  }
}

}  // namespace
}  // namespace rigcal
