#include "core/pipeline/late_images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

std::vector<std::pair<std::string, int>> moved(int by, const std::vector<char>& stop_known) {
  const std::vector<CameraView> views{{0, "a", {}}, {1, "b", {}}, {1, "b too", {}}, {3, "d", {}}};
  std::vector<std::pair<std::string, int>> stops;
  for (const CameraView& view : views_moved(views, by, stop_known)) stops.emplace_back(view.file, view.stop);
  return stops;
}

TEST(ViewsMoved, AreOfTheStopsBeside) {
  const std::vector<char> known{1, 1, 1, 1};
  EXPECT_THAT(moved(-1, known), ElementsAre(Pair("b", 0), Pair("b too", 0), Pair("d", 2)));
  EXPECT_THAT(moved(1, known), ElementsAre(Pair("a", 1), Pair("b", 2), Pair("b too", 2)));
}

TEST(ViewsMoved, AreNotOfStopsWhosePoseNobodyKnows) {
  EXPECT_THAT(moved(-1, {0, 1, 1, 1}), ElementsAre(Pair("d", 2)));
  EXPECT_THAT(moved(1, {1, 0, 0, 1}), IsEmpty());
}

}  // namespace
}  // namespace rigcal
