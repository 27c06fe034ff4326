#include "core/pipeline/stop_groups.h"

#include <gmock/gmock.h>

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

// Every stop sees the floor, and walls that some share.
struct SeenTogether {
  explicit SeenTogether(int stops) : used(static_cast<std::size_t>(stops), 1), told(used.size(), 0) {
    std::vector<int> all;
    for (int j = 0; j < stops; ++j) all.push_back(j);
    add(Vector3d::UnitZ(), all, 10000.0);
  }

  void add(const Vector3d& normal, const std::vector<int>& stops, double points) {
    PlaneFeature& plane = map.features.emplace_back();
    plane.normal_G = normal;
    for (const int stop : stops) {
      plane.observations.emplace_back();
      plane.observations.back().stop = stop;
      plane.observations.back().N = points;
    }
  }

  // A corner: its walls face two ways.
  void add_corner(const std::vector<int>& stops, double points = 1000.0) {
    add(Vector3d::UnitX(), stops, points);
    add(Vector3d::UnitY(), stops, points);
  }

  [[nodiscard]] std::vector<std::vector<std::size_t>> groups() const { return stop_groups(used, told, map); }

  std::vector<char> used;
  std::vector<char> told;
  PlaneMap map;
};

TEST(StopGroups, HangTogetherFromNeighbourToNeighbour) {
  SeenTogether seen(5);
  for (int j = 0; j < 4; ++j) seen.add_corner({j, j + 1});
  EXPECT_THAT(seen.groups(), ElementsAre(ElementsAre(0, 1, 2, 3, 4)));
}

TEST(StopGroups, AreNotHeldByAFloor) {
  SeenTogether seen(5);
  seen.add_corner({0, 1});
  seen.add_corner({2, 3, 4});
  EXPECT_THAT(seen.groups(), ElementsAre(ElementsAre(2, 3, 4), ElementsAre(0, 1)));
}

TEST(StopGroups, AreNotHeldByTheFewPlanesThatFallTogetherByChance) {
  SeenTogether seen(6);
  seen.add_corner({0, 1, 2});
  seen.add_corner({3, 4, 5});
  seen.add_corner({0, 1, 2, 3, 4, 5}, 80.0);
  EXPECT_THAT(seen.groups(), ElementsAre(ElementsAre(0, 1, 2), ElementsAre(3, 4, 5)));
  seen.add_corner({2, 3}, 100.0);
  EXPECT_THAT(seen.groups(), ElementsAre(ElementsAre(0, 1, 2, 3, 4, 5)));
}

// What many stops see together is no more at its seam than what one stop sees.
TEST(StopGroups, OfManyStopsHangTogetherByWhatTwoOfThemShare) {
  SeenTogether seen(40);
  for (int j = 0; j < 19; ++j) {
    seen.add_corner({j, j + 1});
    seen.add_corner({20 + j, 21 + j});
  }
  seen.add_corner({7, 33}, 500.0);
  EXPECT_EQ(seen.groups().size(), 1);
}

// A stop whose surfaces nobody else saw has no planes but the floor, or next to none.
TEST(StopGroups, LeaveAStopAloneThatSharesNothing) {
  SeenTogether seen(5);
  seen.add_corner({0, 1, 2, 3});
  seen.add_corner({3, 4}, 20.0);
  EXPECT_THAT(seen.groups(), ElementsAre(ElementsAre(0, 1, 2, 3), ElementsAre(4)));
}

TEST(StopGroups, HangTogetherWhereSomethingElseTellsTheTurn) {
  SeenTogether seen(6);
  seen.add_corner({0, 1, 2});
  seen.add_corner({4, 5});
  seen.used[3] = 0;
  seen.told[4] = 1;
  EXPECT_THAT(seen.groups(), ElementsAre(ElementsAre(0, 1, 2), ElementsAre(4, 5)));
  seen.told[3] = 1;
  EXPECT_THAT(seen.groups(), ElementsAre(ElementsAre(0, 1, 2, 4, 5)));
}

TEST(StopGroups, AreToldByPlanesThatWereMadeOfPoints) {
  SeenTogether seen(4);
  seen.add_corner({0, 1});
  seen.add_corner({2, 3});
  seen.add_corner({0, 1, 2, 3});
  for (std::size_t k = seen.map.features.size() - 2; k < seen.map.features.size(); ++k) {
    seen.map.features[k].merged = true;
  }
  EXPECT_THAT(seen.groups(), ElementsAre(ElementsAre(0, 1), ElementsAre(2, 3)));
}

TEST(StopGroups, AreOneWhereNothingHoldsAnyTurn) {
  EXPECT_THAT(SeenTogether(3).groups(), ElementsAre(ElementsAre(0, 1, 2)));
  SeenTogether none(3);
  none.map.features.clear();
  EXPECT_THAT(none.groups(), ElementsAre(ElementsAre(0, 1, 2)));
  EXPECT_TRUE(SeenTogether(0).groups().empty());
}

TEST(StopGroups, AreNamedByTheirNumbers) {
  EXPECT_THAT(apart_words({5}), StartsWith("stop 5 is left out: "));
  EXPECT_THAT(apart_words({0, 1, 2, 4, 7, 8}), StartsWith("stops 0 to 2, 4, 7, 8 are left out: "));
  EXPECT_THAT(apart_words({5}), HasSubstr("smaller steps"));
}

}  // namespace
}  // namespace rigcal
