#include "core/edges/line_book.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

LidarEdge at(const Vector3d& p, const Vector3d& direction) {
  LidarEdge edge;
  edge.p_G = p;
  edge.direction_G = direction.normalized();
  return edge;
}

// Upright lines 0.3 m apart, more than are looked at together.
Vector3d foot(int line) { return {0.3 * line, 5.0, 0.0}; }
constexpr int lines = 53;

TEST(LineBook, GivesWhatLiesOnALineItsNumber) {
  LineBook book(0.05, 7);
  for (int line = 0; line < lines; ++line) book.add({at(foot(line), Vector3d::UnitZ())});
  // Farther up, a little beside and turned round; then what is too far beside, and what is level.
  for (int line = 0; line < lines; ++line)
    book.add({at(foot(line) + Vector3d(0.03, 0.0, 2.0), -Vector3d(0.0, 0.03, 1.0))});
  book.add({at(foot(20) + Vector3d(0.0, 0.06, 2.0), Vector3d::UnitZ())});
  book.add({at(foot(20), Vector3d::UnitX())});
  const std::vector<LidarEdge> edges = book.take();
  ASSERT_EQ(edges.size(), 2U * lines + 2U);
  for (int line = 0; line < lines; ++line) {
    EXPECT_EQ(edges[static_cast<std::size_t>(line)].line, 7 + line);
    EXPECT_EQ(edges[static_cast<std::size_t>(lines + line)].line, 7 + line);
  }
  EXPECT_EQ(edges[2 * lines].line, 7 + lines);
  EXPECT_EQ(edges[2 * lines + 1].line, 8 + lines);
}

TEST(LineBook, KeepsOneOfTwoSamplesOfAPlace) {
  LineBook book(0.05);
  book.add({at({0.0, 0.0, 0.01}, Vector3d::UnitZ()), at({0.0, 0.0, 0.07}, Vector3d::UnitZ())});
  book.add({at({0.0, 0.0, 0.012}, Vector3d::UnitZ()), at({0.0, 0.0, 0.13}, Vector3d::UnitZ())});
  EXPECT_EQ(book.take().size(), 3U);
}

}  // namespace
}  // namespace rigcal
