#include "core/base/error.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

TEST(Error, MessageNamesPlaceAndMend) {
  EXPECT_EQ(input_error("unknown key 'foo'", "rig.yaml:3", "did you mean 'for'?").message(),
            "rig.yaml:3: unknown key 'foo'; did you mean 'for'?");
  EXPECT_EQ(input_error("no packet").message(), "no packet");
  EXPECT_EQ(cancelled_error("stopped", "run.pcap").message(), "run.pcap: stopped");
}

TEST(Expected, HoldsAValueOrAnError) {
  const Expected<int> good = 3;
  ASSERT_TRUE(good);
  EXPECT_EQ(*good, 3);
  const Expected<int> bad = input_error("broken");
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().what, "broken");
  const Expected<void> nothing;
  EXPECT_TRUE(nothing);
}

TEST(ExpectedDeath, ReadingAMissingValueSaysWhichErrorWasIgnored) {
  const Expected<int> bad = input_error("broken");
  EXPECT_DEATH((void)bad.value(), "broken");
}

}  // namespace
}  // namespace rigcal
