#include "drivers/camera/frame_counter.h"

#include <gtest/gtest.h>

namespace rigcal::camera {
namespace {

TEST(FrameCounter, CountsWhatNeverCame) {
  FrameCounter counter(v4l2_sequence_numbers);
  EXPECT_EQ(counter.missing_before(7), 0U);
  EXPECT_EQ(counter.missing_before(8), 0U);
  EXPECT_EQ(counter.missing_before(11), 2U);
}

TEST(FrameCounter, GoesOnWhereIdsBeginAgain) {
  FrameCounter gige(gige_block_ids);
  EXPECT_EQ(gige.missing_before(65534), 0U);
  EXPECT_EQ(gige.missing_before(65535), 0U);
  EXPECT_EQ(gige.missing_before(1), 0U);
  EXPECT_EQ(gige.missing_before(65534), 0U) << "a late frame is no round";
  EXPECT_EQ(gige.missing_before(4), 2U);
}

TEST(FrameCounter, FramesThatComeTwiceOrLateAreNoLoss) {
  FrameCounter counter(v4l2_sequence_numbers);
  EXPECT_EQ(counter.missing_before(100), 0U);
  EXPECT_EQ(counter.missing_before(100), 0U);
  EXPECT_EQ(counter.missing_before(98), 0U);
  EXPECT_EQ(counter.missing_before(102), 1U);
}

TEST(FrameCounter, ACameraThatCountsAnewHasLostNothing) {
  FrameCounter counter(gige_block_ids);
  EXPECT_EQ(counter.missing_before(500), 0U);
  EXPECT_EQ(counter.missing_before(1), 0U);
  EXPECT_EQ(counter.missing_before(2), 0U);
  FrameCounter usb(usb3_block_ids);
  EXPECT_EQ(usb.missing_before(5), 0U);
  EXPECT_EQ(usb.missing_before(1'000'000'000'000), 0U);
  EXPECT_EQ(usb.missing_before(1'000'000'000'002), 1U);
}

TEST(FrameCounter, IdsThatTheCameraCannotHaveAreNotCounted) {
  FrameCounter counter(gige_block_ids);
  EXPECT_EQ(counter.missing_before(10), 0U);
  EXPECT_EQ(counter.missing_before(70000), 0U);
  EXPECT_EQ(counter.missing_before(11), 0U);
}

}  // namespace
}  // namespace rigcal::camera
