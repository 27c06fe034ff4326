#include "core/pipeline/stop_misfits.h"

#include <gmock/gmock.h>

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// One LiDAR, 1000 points a stop, of which shares lie on one plane.
struct SeenMisfits {
  explicit SeenMisfits(const std::vector<double>& shares) : stops(static_cast<int>(shares.size())) {
    map.features.emplace_back();
    for (int j = 0; j < stops; ++j) {
      PatchCells& patch = patches.emplace_back();
      patch.stop = j;
      patch.cells.resize(2);
      for (Cell& cell : patch.cells) cell.N = 500.0;
      PlaneObservation& o = map.features.front().observations.emplace_back();
      o.stop = j;
      o.N = 1000.0 * shares[static_cast<std::size_t>(j)];
    }
    use.assign(patches.size(), 1);
  }

  [[nodiscard]] std::vector<std::size_t> misfits() const { return misfit_stops(stops, patches, use, map); }

  int stops;
  std::vector<PatchCells> patches;
  std::vector<char> use;
  PlaneMap map;
};

TEST(MisfitStops, AreThoseOfWhichMuchLessLiesOnPlanesThanOfTheOthers) {
  EXPECT_THAT(SeenMisfits({0.5, 0.6, 0.1, 0.7, 0.19, 0.5}).misfits(), ElementsAre(2, 4));
  EXPECT_THAT(SeenMisfits({0.5, 0.6, 0.3, 0.7, 0.25, 0.5}).misfits(), IsEmpty());
}

TEST(MisfitStops, AreNoneWhereNothingLiesOnAnyPlane) {
  EXPECT_THAT(SeenMisfits({0.0, 0.0, 0.0, 0.0, 0.0}).misfits(), IsEmpty());
}

TEST(MisfitStops, AreNoneOfFewerThanFourStops) {
  EXPECT_THAT(SeenMisfits({0.6, 0.6, 0.0}).misfits(), IsEmpty());
  EXPECT_THAT(SeenMisfits({0.6, 0.6, 0.6, 0.0}).misfits(), ElementsAre(3));
}

TEST(MisfitStops, AreNotThoseThatTookNoPart) {
  SeenMisfits seen({0.6, 0.6, 0.6, 0.6, 0.0, 0.0});
  seen.use[4] = 0;
  EXPECT_THAT(seen.misfits(), ElementsAre(5));
}

TEST(MisfitStops, AreToldByPlanesThatWereMadeOfPoints) {
  SeenMisfits seen({0.6, 0.6, 0.6, 0.0});
  PlaneFeature merged = seen.map.features.front();  // would count the same points twice, and the last stop's at all
  merged.merged = true;
  for (PlaneObservation& o : merged.observations) o.N = 600.0;
  seen.map.features.push_back(merged);
  EXPECT_THAT(seen.misfits(), ElementsAre(3));
}

}  // namespace
}  // namespace rigcal
