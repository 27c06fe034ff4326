#include "core/frames/frame_ids.h"

#include <gtest/gtest.h>

#include <limits>

namespace rigcal {
namespace {

TEST(FrameIds, WrapAtTheirWidthAndSkipZeroWhereTheProtocolDoes) {
  EXPECT_EQ(frame_steps(gige_block_ids, 65535, 1), 1);
  EXPECT_EQ(frame_steps(gige_block_ids, 65530, 4), 9);
  EXPECT_EQ(frame_steps(gige_block_ids, 1, 65535), -1);
  EXPECT_EQ(frame_steps(v4l2_sequence_numbers, 0xFFFFFFFF, 0), 1);
  EXPECT_EQ(frame_steps(v4l2_sequence_numbers, 0xFFFFFFFF, 1), 2);
  EXPECT_EQ(frame_steps(extended_block_ids, 65535, 65536), 1);
  EXPECT_EQ(frame_steps(usb3_block_ids, std::numeric_limits<std::uint64_t>::max(), 0), 1);
  EXPECT_EQ(frame_steps(gige_block_ids, 7, 7), 0);
  EXPECT_EQ(frame_steps(gige_block_ids, 1 << 20, 5), 5 - 16);  // Wider than the rule says: 2^20 is 16 in this count.
}

TEST(FrameIds, WitnessNoticesWhatTimeAloneWouldGetWrong) {
  IdWitness witness(v4l2_sequence_numbers);
  EXPECT_TRUE(witness.agrees(10, 100));
  EXPECT_TRUE(witness.agrees(11, 101));
  EXPECT_TRUE(witness.agrees(14, 104));   // Three frames were lost.
  EXPECT_FALSE(witness.agrees(15, 106));  // So late that time says the next pulse.
  EXPECT_TRUE(witness.agrees(16, 106));
}

TEST(FrameIds, WitnessBelievesThatTheCameraCountsAnew) {
  IdWitness witness(v4l2_sequence_numbers);
  EXPECT_TRUE(witness.agrees(1000, 100));
  EXPECT_FALSE(witness.agrees(0, 101));
  EXPECT_FALSE(witness.agrees(1, 102));
  EXPECT_TRUE(witness.agrees(2, 103));
  EXPECT_TRUE(witness.agrees(3, 104));
}

TEST(FrameIds, WitnessDoesNotBelieveContradictionsThatDiffer) {
  IdWitness witness(v4l2_sequence_numbers);
  EXPECT_TRUE(witness.agrees(10, 100));
  // Frames that were held up and come all at once: time says the same pulse for all.
  for (std::uint64_t id = 11; id < 16; ++id) EXPECT_FALSE(witness.agrees(id, 106)) << id;
  EXPECT_TRUE(witness.agrees(16, 106));
}

}  // namespace
}  // namespace rigcal
