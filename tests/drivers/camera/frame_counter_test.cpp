#include "drivers/camera/frame_counter.h"

#include <gtest/gtest.h>

namespace rigcal::camera {
namespace {

TEST(FrameCounter, CountsWhatNeverCame) {
  FrameCounter counter(0, UINT32_MAX);
  EXPECT_EQ(counter.missing_before(7), 0U);
  EXPECT_EQ(counter.missing_before(8), 0U);
  EXPECT_EQ(counter.missing_before(11), 2U);
}

TEST(FrameCounter, GoesOnWhereIdsBeginAgain) {
  FrameCounter gige(1, 65535);
  EXPECT_EQ(gige.missing_before(65534), 0U);
  EXPECT_EQ(gige.missing_before(65535), 0U);
  EXPECT_EQ(gige.missing_before(1), 0U);
  EXPECT_EQ(gige.missing_before(65535 - 1), 0U) << "a late frame is no round";
  EXPECT_EQ(gige.missing_before(4), 2U);
  FrameCounter wide(0, UINT64_MAX);
  EXPECT_EQ(wide.missing_before(UINT64_MAX - 1), 0U);
  EXPECT_EQ(wide.missing_before(1), 2U);
}

TEST(FrameCounter, FramesThatComeTwiceOrLateAreNoLoss) {
  FrameCounter counter(0, UINT32_MAX);
  EXPECT_EQ(counter.missing_before(100), 0U);
  EXPECT_EQ(counter.missing_before(100), 0U);
  EXPECT_EQ(counter.missing_before(98), 0U);
  EXPECT_EQ(counter.missing_before(102), 1U);
}

TEST(FrameCounter, ACameraThatBeginsAnewHasLostNothing) {
  FrameCounter counter(1, 65535);
  EXPECT_EQ(counter.missing_before(500), 0U);
  EXPECT_EQ(counter.missing_before(1), 0U);
  EXPECT_EQ(counter.missing_before(2), 0U);
  counter.restart();
  EXPECT_EQ(counter.missing_before(900), 0U);
}

TEST(FrameCounter, IdsOutOfTheirRangeAreNotCounted) {
  FrameCounter counter(1, 65535);
  EXPECT_EQ(counter.missing_before(10), 0U);
  EXPECT_EQ(counter.missing_before(0), 0U);
  EXPECT_EQ(counter.missing_before(70000), 0U);
  EXPECT_EQ(counter.missing_before(11), 0U);
}

}  // namespace
}  // namespace rigcal::camera
