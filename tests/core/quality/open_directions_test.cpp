#include "core/quality/open_directions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/make_planes.h"

namespace rigcal {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Of a sensor that looks backwards: its own axes are not the base's.
const SE3 backwards{exp_so3({0.0, 0.0, pi}), {0.1, 0.0, 0.0}};

Matrix6d covariance(const Vector3d& sigma_rad, const Vector3d& sigma_m) {
  Vector6d variances;
  variances << sigma_rad.cwiseAbs2(), sigma_m.cwiseAbs2();
  return variances.asDiagonal();
}

TEST(OpenDirections, AreNoneWhereAllIsHeld) {
  const OpenDirections open = open_directions(covariance(Vector3d::Constant(1e-3), Vector3d::Constant(0.1)), backwards);
  EXPECT_EQ(open.what, "");
}

TEST(OpenDirections, OneOfAPlaceAsksForASurfaceThatFacesIt) {
  const OpenDirections up = open_directions(covariance(Vector3d::Constant(1e-3), {0.01, 0.01, 1.0}), backwards);
  EXPECT_EQ(up.what, "its place along z (up and down) of the base frame");
  EXPECT_EQ(up.surface, "a level surface (a floor, a ceiling, a table)");
  const OpenDirections sideways = open_directions(covariance(Vector3d::Constant(1e-3), {0.01, 1.0, 0.01}), backwards);
  EXPECT_EQ(sideways.surface, "an upright surface that faces along y (sideways) of the base frame");
}

TEST(OpenDirections, OverAFloorAllLevelOnesAndTheTurnAboutThePlumbLineAre) {
  const OpenDirections open = open_directions(covariance({1e-3, 1e-3, 0.5}, {2.0, 1.0, 0.01}), backwards);
  EXPECT_THAT(open.what, AllOf(HasSubstr("(all level ones)"), HasSubstr("and its turn about z (up and down)")));
  EXPECT_EQ(open.surface, "upright flat surfaces that face two ways");
}

TEST(OpenDirections, OfTurnsAloneAskForWhatHoldsThem) {
  const OpenDirections open = open_directions(covariance({1e-3, 1e-3, 0.5}, Vector3d::Constant(0.01)), backwards);
  EXPECT_EQ(open.what, "its turn about z (up and down) of the base frame");
  EXPECT_EQ(open.surface, "an upright flat surface");
}

TEST(WeakDirections, AreTheAxesBeyondWhatIsAskedForTheWorstFirst) {
  const Requirement require{0.01, to_rad(0.1)};
  const Vector3d sure_turn = Vector3d::Constant(1e-5);
  EXPECT_TRUE(weak_directions(covariance(sure_turn, Vector3d::Constant(1e-3)), backwards, require).empty());

  const auto places = weak_directions(covariance(sure_turn, {0.02, 1e-3, 0.05}), backwards, require, Vector3d::UnitZ());
  ASSERT_EQ(places.size(), 2U);
  EXPECT_NEAR(places[0].bound, std::sqrt(7.815) * 0.05, 1e-9);
  EXPECT_NEAR(std::abs(places[0].axis.z()), 1.0, 1e-9);
  EXPECT_EQ(places[0].missing, "a level surface (a floor, a ceiling, a table)");
  EXPECT_TRUE(places[0].is_frozen);
  EXPECT_FALSE(places[0].is_turn || places[0].is_open);
  EXPECT_EQ(places[1].missing, "an upright surface that faces along x (forwards) of the base frame");
  EXPECT_FALSE(places[1].is_frozen);

  const auto turns = weak_directions(covariance({1e-5, 1e-5, 0.3}, {1e-3, 1e-3, 0.3}), backwards, require);
  ASSERT_EQ(turns.size(), 2U);
  EXPECT_TRUE(turns[0].is_open && !turns[0].is_turn);
  EXPECT_TRUE(turns[1].is_open && turns[1].is_turn);
  EXPECT_EQ(turns[1].missing, "an upright flat surface");
}

// What is told of it must be in its own frame: a sensor on its side has its x upright.
TEST(WeakDirections, AreFrozenInTheSensorsFrame) {
  const SE3 on_its_side{exp_so3({0.0, -0.5 * pi, 0.0}), Vector3d::Zero()};
  const auto weak =
      weak_directions(covariance(Vector3d::Constant(1e-5), {0.05, 1e-3, 1e-3}), on_its_side, {}, Vector3d::UnitX());
  ASSERT_EQ(weak.size(), 1U);
  EXPECT_NEAR(std::abs(weak[0].axis.z()), 1.0, 1e-9);
  EXPECT_TRUE(weak[0].is_frozen);
}

// One upright wall that every stop meets head on.
class WallAhead : public testing::Test {
 protected:
  void SetUp() override {
    // A turn about the wall's normal leaves it where it is.
    state_ = {{SE3{}, SE3{exp_so3({to_rad(3.0), 0.0, 0.0}), Vector3d::Zero()}}, {SE3{}, SE3{}}};
    feature_.normal_G = Vector3d::UnitX();
    for (int stop = 0; stop < 2; ++stop) {
      PlaneObservation o;
      o.stop = stop;
      o.lidar = 1;
      o.N = 100.0;
      o.mean = {5.0, 0.3 * stop, 0.0};
      o.scatter = Vector3d(0.0, 8.0, 5.0).asDiagonal();
      o.offset_variance = 1e-6;
      feature_.observations.push_back(o);
    }
  }
  [[nodiscard]] std::optional<HelpfulTurn> turn(const Vector3d& sigma_m) const {
    const std::vector<PlaneFeature> features{feature_};
    return turn_for_weak_translation({features, state_, layout_, adjust_}, 1,
                                     covariance(Vector3d::Constant(1e-3), sigma_m));
  }

  RigState state_;
  PlaneFeature feature_;
  ParameterLayout layout_{2, 2};
  AdjustOptions adjust_;
};

TEST_F(WallAhead, FacesSidewaysAfterAQuarterTurn) {
  const auto sideways = turn({0.01, 1.0, 0.01});
  ASSERT_TRUE(sideways);
  EXPECT_NEAR(std::abs(sideways->by_rad), 0.5 * pi, 1e-6);
  EXPECT_NEAR(sideways->seen_rad, to_rad(3.0), 1e-6);
  EXPECT_THAT(turn_words(sideways), HasSubstr("after a turn of about 90 degrees (so far the rig turned by 3 degrees"));
}

TEST_F(WallAhead, HelpsNeitherTheHeightNorWhereItFacesAlready) {
  EXPECT_FALSE(turn({0.01, 0.01, 1.0}));
  EXPECT_FALSE(turn({1.0, 0.01, 0.01}));
}

// After a turn of the rig to the right by 70 degrees the wall ahead stands to its left by 70.
TEST_F(WallAhead, IsTurnedAgainstTheRig) {
  const Vector3d d = exp_so3({0.0, 0.0, to_rad(70.0)}) * Vector3d::UnitX();
  Matrix6d C = covariance(Vector3d::Constant(1e-3), Vector3d::Constant(0.01));
  C.bottomRightCorner<3, 3>() += d * d.transpose();
  const std::vector<PlaneFeature> features{feature_};
  const auto turned = turn_for_weak_translation({features, state_, layout_, adjust_}, 1, C);
  ASSERT_TRUE(turned);
  EXPECT_NEAR(turned->by_rad, -to_rad(70.0), 1e-6);
}

}  // namespace
}  // namespace rigcal
