#include "core/pipeline/place_findings.h"

#include <gtest/gtest.h>

#include "core/pipeline/lidar_result.h"

namespace rigcal {
namespace {

SE3 pose(double yaw_deg, const Vector3d& t) { return {exp_so3(to_rad(yaw_deg) * Vector3d::UnitZ()), t}; }

// A base and three LiDARs, found where they are said to be.
class PlaceFindingsTest : public testing::Test {
 protected:
  PlaceFindingsTest() {
    solution_.state.T_base_sensor = {SE3{}, pose(120.0, {-0.1, 0.2, -0.3}), pose(180.0, {-0.2, 0.0, -0.3}),
                                     pose(-120.0, {-0.1, -0.2, -0.3})};
    solution_.start.lidar_known.assign(4, 1);
    for (const SE3& T : solution_.state.T_base_sensor) guess_.push_back(T * pose(3.0, {0.05, 0.0, 0.02}));
    guess_[0] = SE3{};
  }
  [[nodiscard]] std::vector<PlaceFindings> find() const { return place_findings(guess_, solution_, 0); }

  LidarSolution solution_{1, 4};
  std::vector<std::optional<SE3>> guess_;
};

TEST_F(PlaceFindingsTest, AreNoneWhereGuessesAreMerelyRough) {
  const std::vector<PlaceFindings> found = find();
  for (std::size_t i = 1; i < found.size(); ++i) {
    EXPECT_NEAR(to_deg(found[i].from_guess_rad), 3.0, 1e-6);
    EXPECT_NEAR(found[i].from_guess_m, std::hypot(0.05, 0.02), 1e-9);
    EXPECT_FALSE(found[i].stands_at);
    EXPECT_FALSE(found[i].guess_is_inverse);
    EXPECT_FALSE(found[i].same_place_as);
  }
}

TEST_F(PlaceFindingsTest, NameUnitsInTheWrongOrder) {
  std::swap(solution_.state.T_base_sensor[1], solution_.state.T_base_sensor[3]);
  const std::vector<PlaceFindings> found = find();
  EXPECT_EQ(found[1].stands_at, 3);
  EXPECT_EQ(found[3].stands_at, 1);
  EXPECT_FALSE(found[2].stands_at);
}

TEST_F(PlaceFindingsTest, TellInverseGuessesFromUnitsInTheWrongOrder) {
  for (auto& T : guess_) T = T->inverse();
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_TRUE(find()[i].guess_is_inverse);
    EXPECT_FALSE(find()[i].stands_at);
  }
}

TEST_F(PlaceFindingsTest, NameWhoStandsJustWhereAnotherDoes) {
  solution_.state.T_base_sensor[1] = solution_.state.T_base_sensor[2] * pose(0.01, {0.001, 0.0, 0.0});
  const std::vector<PlaceFindings> found = find();
  EXPECT_EQ(found[1].same_place_as, 2);
  EXPECT_EQ(found[2].same_place_as, 1);
  EXPECT_FALSE(found[3].same_place_as);
  solution_.start.lidar_known[2] = 0;
  EXPECT_FALSE(find()[1].same_place_as);
}

}  // namespace
}  // namespace rigcal
