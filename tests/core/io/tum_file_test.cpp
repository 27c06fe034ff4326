#include "core/io/tum_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/io/dump_bytes.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

std::int64_t stamp_of(const std::string& word) {
  const Expected<std::vector<TumPose>> poses = parse_tum(word + " 0 0 0 0 0 0 1\n", "t.tum");
  EXPECT_TRUE(poses) << word;
  return poses ? poses->at(0).stamp_ns : -1;
}

TEST(TumFile, KeepsEveryNanosecond) {
  const std::string path = fresh_path("t.tum");
  const std::vector<TumPose> poses{
      {1'700'000'000'123'456'789, pose_deg(10, -20, 170, 0.1, -1e5, 1.0 / 3.0), 0}, {-1, SE3{}, 0}, {5, SE3{}, 0}};
  ASSERT_TRUE(write_tum(path, poses, "remark"));
  const Expected<std::vector<TumPose>> again = read_tum(path);
  ASSERT_TRUE(again) << again.error().message();
  ASSERT_EQ(again->size(), 3U);
  EXPECT_EQ(again->at(0).stamp_ns, poses[0].stamp_ns);
  EXPECT_EQ(again->at(1).stamp_ns, -1);
  EXPECT_EQ(again->at(2).stamp_ns, 5);
  // Translations to the bit; rotations go through a quaternion.
  EXPECT_EQ(again->at(0).pose.t, poses[0].pose.t);
  EXPECT_THAT(again->at(0).pose, SE3Near(poses[0].pose, 1e-12, 0.0));
  EXPECT_EQ(again->at(0).line, 2);
}

TEST(TumFile, ReadsStampsAsOthersWriteThem) {
  EXPECT_EQ(stamp_of("1403636580.8383555"), 1'403'636'580'838'355'500);
  EXPECT_EQ(stamp_of("7"), 7'000'000'000);
  EXPECT_EQ(stamp_of("0.0000000006"), 1);
  EXPECT_EQ(stamp_of("1.5e1"), 15'000'000'000);
  EXPECT_EQ(stamp_of("1.500000000000000000e+00"), 1'500'000'000);
}

TEST(TumFile, NamesTheLineOfAMistake) {
  const auto message = [](const std::string& text) { return parse_tum(text, "t.tum").error().message(); };
  EXPECT_THAT(message("0 0 0 0 0 0 0 1\n0 0 0 0 0 0 1\n"), HasSubstr("t.tum:2: is not a pose"));
  EXPECT_THAT(message("0 0 0 0 0 0 0 1 9"), HasSubstr("t.tum:1"));
  EXPECT_THAT(message("0 nan 0 0 0 0 0 1"), HasSubstr("t.tum:1"));
  EXPECT_THAT(message("99999999999 0 0 0 0 0 0 1"), HasSubstr("t.tum:1"));
  EXPECT_THAT(message("0 0 0 0 0 0 0 0.9"), HasSubstr("quaternion of the length 0.9"));
}

}  // namespace
}  // namespace rigcal
