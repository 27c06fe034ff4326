#include "drivers/trigger/edge_levels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace rigcal::trigger {
namespace {

/// Edges as the kernel reports them, "r" and "f", with numbers from `first` (0: all without), after mending.
std::string mended(EdgeLevels& levels, const std::string& reported, std::uint64_t first = 1) {
  std::vector<Edge> edges;
  for (const char way : reported) {
    const std::uint64_t sequence = first == 0 ? 0 : first + edges.size();
    edges.push_back({static_cast<std::int64_t>(1000 * edges.size()), way == 'r', sequence});
  }
  levels.mend(edges);
  std::string ways;
  for (const Edge& edge : edges) ways += edge.is_rising ? 'r' : 'f';
  return ways;
}

TEST(EdgeLevels, LeaveWhatIsInOrder) {
  EdgeLevels levels;
  EXPECT_EQ(mended(levels, "rfrfrf"), "rfrfrf");
  EXPECT_EQ(mended(levels, "rfr", 7), "rfr");
  EXPECT_EQ(levels.mended(), 0U);
}

TEST(EdgeLevels, TakeASecondFallingEdgeForARisingOneThatWasReadLate) {
  for (const std::uint64_t first : {0U, 1U}) {
    EdgeLevels levels;
    EXPECT_EQ(mended(levels, "rfffrfffff", first), "rfrfrfrfrf");
    EXPECT_EQ(levels.mended(), 3U);
  }
}

TEST(EdgeLevels, BelieveAFallingEdgeAtFirstAndAfterAGap) {
  EdgeLevels levels;
  EXPECT_EQ(mended(levels, "frf"), "frf");
  EXPECT_EQ(mended(levels, "frf", 5), "frf");
  levels.forget();
  EXPECT_EQ(mended(levels, "f"), "f");
  EXPECT_EQ(levels.mended(), 0U);
}

TEST(EdgeLevels, FindBackAfterALostEdgeWithoutNumbers) {
  EdgeLevels levels;
  EXPECT_EQ(mended(levels, "rfrrfrf", 0), "rfrrfrf");
  EXPECT_EQ(mended(levels, "frfrf", 0), "rrfrf");
}

}  // namespace
}  // namespace rigcal::trigger
