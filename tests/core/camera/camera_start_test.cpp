#include "core/camera/camera_start.h"

#include <gtest/gtest.h>

#include "tests/core/camera/textured_room.h"

namespace rigcal {
namespace {

TEST(CameraStart, FindsACameraOfWhichNothingIsKnown) {
  const TexturedRoom room = make_textured_room(true, 12);
  SilentReporter reporter;
  const CameraStarts starts = find_camera_starts(room.scene, room.camera, {reporter});
  ASSERT_FALSE(starts.T_base_camera.empty()) << starts.why_none;
  const SE3& best = starts.T_base_camera.front();
  EXPECT_LT(rotation_distance(best.R, room.truth.R), to_rad(2.0));
  EXPECT_LT((best.t - room.truth.t).norm(), 0.15);
}

TEST(CameraStart, SaysWhatIsMissing) {
  TexturedRoom room = make_textured_room();
  SilentReporter reporter;
  const CameraStarts quarter_turns = find_camera_starts(room.scene, room.camera, {reporter});
  EXPECT_TRUE(quarter_turns.T_base_camera.empty());
  EXPECT_NE(quarter_turns.why_none.find("50 degrees"), std::string::npos) << quarter_turns.why_none;
  room.scene.turn.reset();
  const CameraStarts drove = find_camera_starts(room.scene, room.camera, {reporter});
  EXPECT_TRUE(drove.T_base_camera.empty());
  EXPECT_NE(drove.why_none.find("in place"), std::string::npos) << drove.why_none;
}

}  // namespace
}  // namespace rigcal
