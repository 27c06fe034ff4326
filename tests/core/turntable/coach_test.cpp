#include "core/turntable/coach.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal {
namespace {

CaptureProgress at(CaptureState state) {
  CaptureProgress progress;
  progress.state = state;
  progress.wanted_stops = 20;
  progress.dwell_s = 2.0;
  return progress;
}

TEST(Coach, SaysWhatToDoInEachState) {
  EXPECT_EQ(advice(at(CaptureState::idle)), "not begun");
  CaptureProgress checking = at(CaptureState::checking);
  checking.absent = {"avia", "camera_left"};
  EXPECT_EQ(advice(checking), "hold still: waiting for avia, camera_left");
  CaptureProgress waiting = at(CaptureState::waiting_for_still);
  EXPECT_EQ(advice(waiting), "hold still");
  waiting.left_early = true;
  EXPECT_EQ(advice(waiting), "moved too early, that stop does not count: hold still");
  EXPECT_EQ(advice(at(CaptureState::settling)), "hold still: the swing fades");
  CaptureProgress capturing = at(CaptureState::capturing);
  capturing.stop = 4;  // Two before it were left too early: it has the number that events and files have.
  capturing.stops = 2;
  capturing.rested_s = 0.9;
  EXPECT_EQ(advice(capturing), "hold still: stop 4, 45 %");
  capturing.rested_s = 2.0;
  capturing.awaited = {"camera_left"};
  EXPECT_EQ(advice(capturing), "hold still: no image of camera_left yet");
  capturing.is_full = true;
  capturing.stops = 3;
  EXPECT_EQ(advice(capturing), "done, turn by 18 degrees and hold still");
  capturing.turns_itself = true;
  EXPECT_EQ(advice(capturing), "done, the table turns");
  CaptureProgress moving = at(CaptureState::moving);
  moving.wanted_stops = 16;
  EXPECT_EQ(advice(moving), "turn by 22.5 degrees, then hold still");
  moving.table_is_turning = true;
  EXPECT_EQ(advice(moving), "the table turns");
  CaptureProgress ended = at(CaptureState::ended);
  ended.stops = 1;
  EXPECT_EQ(advice(ended), "ended: 1 stop");
  CaptureProgress failed = at(CaptureState::failed);
  failed.failure = "the disk is full";
  EXPECT_EQ(advice(failed), "the disk is full");
}

TEST(Coach, WithoutAGoalTheStepIsTheUsualOne) {
  CaptureProgress open = at(CaptureState::moving);
  open.wanted_stops = 0;
  EXPECT_EQ(step_deg(open), 18.0);
  EXPECT_EQ(step_deg(at(CaptureState::moving)), 18.0);
}

}  // namespace
}  // namespace rigcal
