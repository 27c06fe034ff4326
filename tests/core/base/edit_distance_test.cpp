#include "core/base/edit_distance.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

TEST(EditDistance, CountsLettersAddedTakenAwayAndChanged) {
  EXPECT_EQ(edit_distance("lidar", "lidar"), 0U);
  EXPECT_EQ(edit_distance("lidar", "ldar"), 1U);
  EXPECT_EQ(edit_distance("lidar", "lidars"), 1U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("abc", ""), 3U);
}

}  // namespace
}  // namespace rigcal
