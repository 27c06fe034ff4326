#include "core/start/signed_turns.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

TEST(SignedTurns, GoBackWhereTheTableDid) {
  const Vector3d axis = Vector3d(0.2, -0.3, -1.0).normalized();  // of a sensor that hangs upside down
  const std::vector<double> turns_deg{40.0, 40.0, -80.0, 120.0};
  std::vector<std::optional<Matrix3d>> R{std::nullopt};
  for (const double deg : turns_deg) R.emplace_back(exp_so3(to_rad(deg) * axis) * exp_so3(Vector3d(0.004, 0.0, 0.002)));
  R.emplace_back();
  const auto turns = signed_turns(R);
  ASSERT_EQ(turns.size(), R.size());
  EXPECT_FALSE(turns.front());
  EXPECT_FALSE(turns.back());
  for (std::size_t k = 0; k < turns_deg.size(); ++k) EXPECT_NEAR(to_deg(*turns[k + 1]), turns_deg[k], 0.5) << k;
}

TEST(SignedTurns, AreForthWhereAllGoOneWay) {
  const auto turns = signed_turns({std::nullopt, exp_so3(Vector3d(0.0, 0.0, -0.3)), exp_so3(Vector3d(0.0, 0.0, -0.5))});
  EXPECT_DOUBLE_EQ(*turns[1], 0.3);
  EXPECT_DOUBLE_EQ(*turns[2], 0.5);
  EXPECT_TRUE(signed_turns({}).empty());
}

}  // namespace
}  // namespace rigcal
