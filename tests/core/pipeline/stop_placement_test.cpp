#include "core/pipeline/stop_placement.h"

#include <gtest/gtest.h>

#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

// Where the table's axis stands.
const Vector3d foot(0.3, -0.1, 0.0);

// Upright walls about that, each by how far off it stands and the way it faces, and a floor.
struct Wall {
  double distance_m;
  double facing_deg;
};

std::vector<Surfel> room(const std::vector<Wall>& walls) {
  std::vector<Surfel> out;
  const auto add = [&](const Vector3d& mean, const Vector3d& normal) {
    out.push_back({foot + mean, normal, 100.0, 1e-4});
  };
  for (const Wall& wall : walls) {
    const Matrix3d R = exp_so3(to_rad(wall.facing_deg) * Vector3d::UnitZ());
    for (double y = -2.5; y <= 2.5; y += 0.5) {
      for (double z = -1.0; z <= 2.0; z += 0.5) add(R * Vector3d(-wall.distance_m, y, z), R * Vector3d::UnitX());
    }
  }
  for (double x = -2.0; x <= 2.0; x += 0.5) {
    for (double y = -2.0; y <= 2.0; y += 0.5) add({x, y, -1.2}, Vector3d::UnitZ());
  }
  return out;
}

// Looks the same when it is turned by half a turn.
std::vector<Surfel> rectangle() { return room({{3.0, 0.0}, {4.0, 90.0}, {3.0, 180.0}, {4.0, 270.0}}); }
std::vector<Surfel> irregular() { return room({{3.0, 0.0}, {4.0, 70.0}, {3.5, 150.0}, {5.0, 205.0}, {4.4, 290.0}}); }

// A LiDAR that sees all of it from stops at these angles, beside the table's axis; all but the last are known.
class Table {
 public:
  Table(const std::vector<Surfel>& seen, const std::vector<double>& stops_deg) {
    solved_.state.T_base_sensor.resize(1);
    solved_.lidar_known.assign(1, 1);
    for (std::size_t j = 0; j < stops_deg.size(); ++j) {
      const Matrix3d R = exp_so3(to_rad(stops_deg[j]) * Vector3d::UnitZ());
      truth_.push_back({R, foot - R * foot});
      const SE3 T_this_G = truth_.back().inverse();
      PatchSurfels& patch = surfels_.emplace_back(PatchSurfels{0, static_cast<int>(j), seen});
      for (Surfel& s : patch.surfels) {
        s.mean = T_this_G * s.mean;
        s.normal = T_this_G.R * s.normal;
      }
    }
    solved_.state.T_G_base = truth_;
    solved_.state.T_G_base.back() = SE3{};
    solved_.stop_known.assign(stops_deg.size(), 1);
    solved_.stop_known.back() = 0;
  }

  void forget(std::size_t stop) {
    solved_.stop_known[stop] = 0;
    solved_.state.T_G_base[stop] = SE3{exp_so3(Vector3d(0.0, 0.0, 1.0)), Vector3d(2.0, 0.0, 0.0)};
  }
  [[nodiscard]] PlacementInput last(int from) const {
    return {solved_, surfels_, static_cast<int>(truth_.size()) - 1, from};
  }
  [[nodiscard]] const std::vector<SE3>& truth() const { return truth_; }

 private:
  std::vector<SE3> truth_;
  std::vector<PatchSurfels> surfels_;
  Start solved_;
};

TEST(PlaceStop, GoesOnFromTheLastKnownStop) {
  Table table(irregular(), {0.0, 40.0, 80.0, 120.0, 160.0});
  table.forget(3);
  const Matrix3d told = exp_so3(to_rad(79.0) * Vector3d::UnitZ());
  const auto T = place_stop(table.last(2), told);
  ASSERT_TRUE(T);
  EXPECT_THAT(*T, SE3Near(table.truth().back(), 0.3, 10.0));
}

TEST(FindStop, FindsATurnThatNobodyTold) {
  const Table table(irregular(), {0.0, 40.0, 110.0});
  const auto T = find_stop(table.last(1));
  ASSERT_TRUE(T);
  EXPECT_THAT(*T, SE3Near(table.truth().back(), 0.3, 10.0));
}

TEST(FindStop, TakesTheUsualStepWhereOthersFitAsWell) {
  const Table table(rectangle(), {0.0, 40.0, 80.0, 120.0});
  const auto T = find_stop(table.last(2));
  ASSERT_TRUE(T);
  EXPECT_THAT(*T, SE3Near(table.truth().back(), 0.3, 10.0));
  EXPECT_FALSE(find_stop(Table(rectangle(), {0.0, 40.0, 80.0}).last(1)));
}

TEST(FindStop, CountsAUsualStepForEachStopThatWasLeftOut) {
  Table table(rectangle(), {0.0, 40.0, 80.0, 120.0, 160.0});
  table.forget(3);
  const auto T = find_stop(table.last(2));
  ASSERT_TRUE(T);
  EXPECT_THAT(*T, SE3Near(table.truth().back(), 0.3, 10.0));
}

TEST(FindStop, LeavesTheUsualStepWhereAnotherFitsClearlyBetter) {
  const Table table(irregular(), {0.0, 40.0, 80.0, 200.0});
  const auto T = find_stop(table.last(2));
  ASSERT_TRUE(T);
  EXPECT_THAT(*T, SE3Near(table.truth().back(), 0.3, 10.0));
}

TEST(FindStop, FindsNothingWhereNothingFits) {
  const Table table(irregular(), {0.0, 40.0, 80.0, 120.0});
  PlacementInput input = table.last(2);
  std::vector<PatchSurfels> elsewhere = input.surfels;
  elsewhere.back().surfels = room({{8.0, 20.0}, {9.0, 100.0}});
  const PlacementInput unlike{input.solved, elsewhere, input.stop, input.from};
  EXPECT_FALSE(find_stop(unlike));
  EXPECT_TRUE(saw_anything(unlike));
  elsewhere.back().surfels.clear();
  EXPECT_FALSE(saw_anything(unlike));
  EXPECT_FALSE(find_stop(unlike));
}

TEST(FindLeftOut, GoesOnFromWhatItFoundForthAndBack) {
  Table table(irregular(), {0.0, 40.0, 80.0, 120.0, 160.0, 215.0, 240.0});
  for (const std::size_t stop : {0, 1, 4, 5}) table.forget(stop);
  Start start = table.last(3).solved;
  find_left_out(table.last(3).surfels, start);
  for (std::size_t j = 0; j < start.stop_known.size(); ++j) {
    EXPECT_TRUE(start.stop_known[j]) << j;
    EXPECT_THAT(start.state.T_G_base[j], SE3Near(table.truth()[j], 0.3, 10.0)) << j;
  }
}

TEST(FindLeftOut, LeavesOutWhatFitsNowhere) {
  Table table(irregular(), {0.0, 40.0, 80.0, 120.0});
  std::vector<PatchSurfels> surfels = table.last(2).surfels;
  surfels.back().surfels = room({{8.0, 20.0}, {9.0, 100.0}});
  Start start = table.last(2).solved;
  find_left_out(surfels, start);
  EXPECT_EQ(start.stop_known, (std::vector<char>{1, 1, 1, 0}));
}

}  // namespace
}  // namespace rigcal
