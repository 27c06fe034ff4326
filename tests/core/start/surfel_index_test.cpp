#include "core/start/surfel_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/base/random.h"

namespace rigcal {
namespace {

constexpr double reach = 0.5;
constexpr double min_cosine = 0.8;
constexpr double max_plane_distance = 0.2;

Vector3d random_place(Random& random, double half) {
  const double x = random.uniform(-half, half);
  const double y = random.uniform(-half, half);
  const double z = random.uniform(-half, half);
  return {x, y, z};
}

Vector3d random_direction(Random& random) {
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return Vector3d(x, y, z).normalized();
}

// Of 12 groups, one of six faces each, so that queries have a handful of answers.
std::vector<PlacedSurfel> random_surfels(std::size_t count, double half, Random& random) {
  std::vector<PlacedSurfel> surfels;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d place = random_place(random, half);
    const int axis = static_cast<int>(random.below(3));
    const double sign = random.below(2) == 0 ? 1.0 : -1.0;
    const Vector3d bent = sign * Vector3d::Unit(axis) + 0.2 * random_direction(random);
    surfels.push_back({place, bent.normalized(), static_cast<int>(random.below(12))});
  }
  return surfels;
}

struct Query {
  Vector3d p;
  Vector3d normal;
  int not_group;
};

Query random_query(double half, Random& random) {
  const Vector3d p = random_place(random, half);
  const Vector3d normal = random_direction(random);
  return {p, normal, static_cast<int>(random.below(13)) - 1};
}

bool fits(const PlacedSurfel& s, const Query& q, int not_group) {
  return s.group != not_group && s.normal.dot(q.normal) >= min_cosine &&
         std::abs(s.normal.dot(q.p - s.mean)) <= max_plane_distance;
}

struct Scatter {
  std::size_t surfels;
  double half;
};

class SurfelIndexOf : public ::testing::TestWithParam<Scatter> {
 protected:
  void SetUp() override {
    random_ = Random(GetParam().surfels);
    surfels_ = random_surfels(GetParam().surfels, GetParam().half, random_);
  }
  Random random_{0};
  std::vector<PlacedSurfel> surfels_;
};

TEST_P(SurfelIndexOf, FindsTheNearestWithinReachAndBeyondOnlyWhatFits) {
  const SurfelIndex index(surfels_, reach);
  ASSERT_EQ(surfels_.size(), index.size());
  int found = 0;
  for (int k = 0; k < 2000; ++k) {
    const Query q = random_query(GetParam().half, random_);
    double nearest = 1e9;
    for (const PlacedSurfel& s : surfels_) {
      if (fits(s, q, q.not_group)) nearest = std::min(nearest, (q.p - s.mean).norm());
    }
    const int hit = index.find(q.p, q.normal, min_cosine, max_plane_distance, q.not_group);
    if (nearest <= reach) {
      ASSERT_GE(hit, 0);
      EXPECT_EQ(nearest, (q.p - index[hit].mean).norm());
      ++found;
    }
    if (hit >= 0) {
      EXPECT_TRUE(fits(index[hit], q, q.not_group));
      EXPECT_LE((q.p - index[hit].mean).norm(), 2.0 * reach);
    }
    const bool any = index.find(q.p, q.normal, min_cosine, max_plane_distance) >= 0;
    EXPECT_EQ(any, index.contains(q.p, q.normal, min_cosine, max_plane_distance));
  }
  EXPECT_GT(found, 20);
}

TEST_P(SurfelIndexOf, FindsTheNearestOfEachOtherGroupNearestFirst) {
  const SurfelIndex index(surfels_, reach);
  std::vector<int> hits{7, 7, 7};
  std::size_t cut_short = 0;
  for (int k = 0; k < 2000; ++k) {
    const Query q = random_query(GetParam().half, random_);
    std::map<int, double> nearest;
    for (const PlacedSurfel& s : surfels_) {
      const double distance = (q.p - s.mean).norm();
      if (!fits(s, q, q.not_group) || distance > reach) continue;
      const auto [at, is_new] = nearest.try_emplace(s.group, distance);
      if (!is_new) at->second = std::min(at->second, distance);
    }
    std::vector<double> expected;
    for (const auto& [group, distance] : nearest) expected.push_back(distance);
    std::sort(expected.begin(), expected.end());
    constexpr std::size_t most = 3;
    cut_short += expected.size() > most ? 1 : 0;
    expected.resize(std::min(expected.size(), most));
    index.find_all(q.p, q.normal, min_cosine, max_plane_distance, q.not_group, static_cast<int>(most), hits);
    ASSERT_GE(hits.size(), expected.size());
    ASSERT_LE(hits.size(), most);
    std::vector<int> groups;
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const PlacedSurfel& s = index[hits[i]];
      EXPECT_TRUE(fits(s, q, q.not_group));
      groups.push_back(s.group);
      if (i < expected.size())
        EXPECT_EQ(expected[i], (q.p - s.mean).norm());
      else
        EXPECT_GT((q.p - s.mean).norm(), reach);
    }
    std::sort(groups.begin(), groups.end());
    EXPECT_EQ(groups.end(), std::adjacent_find(groups.begin(), groups.end()));
  }
  if (GetParam().half < 3.0) {
    EXPECT_GT(cut_short, 100U);
  }
}

// Crowded; and so far apart that many voxels share a bucket with others.
INSTANTIATE_TEST_SUITE_P(Scatters, SurfelIndexOf, ::testing::Values(Scatter{2000, 1.5}, Scatter{900, 4.0}));

TEST(SurfelIndex, OfNothingFindsNothing) {
  const SurfelIndex index({}, reach);
  std::vector<int> hits{3};
  EXPECT_EQ(-1, index.find(Vector3d::Zero(), Vector3d::UnitX(), -1.0, 1e9));
  EXPECT_FALSE(index.contains(Vector3d::Zero(), Vector3d::UnitX(), -1.0, 1e9));
  index.find_all(Vector3d::Zero(), Vector3d::UnitX(), -1.0, 1e9, -1, 4, hits);
  EXPECT_TRUE(hits.empty());
}

TEST(SurfelIndex, FindsNoneWhereNoneAreAskedFor) {
  Random random(5);
  const SurfelIndex index(random_surfels(100, 0.2, random), reach);
  std::vector<int> hits{3};
  index.find_all(Vector3d::Zero(), Vector3d::UnitX(), -1.0, 1e9, -1, 0, hits);
  EXPECT_TRUE(hits.empty());
}

TEST(WithoutRepetitions, KeepsTheFirstOfEachDirectionInEachCube) {
  Random random(6);
  const auto surfels = random_surfels(2000, 2.0, random);
  constexpr double size = 0.5;
  std::vector<PlacedSurfel> expected;
  const auto cube = [](const Vector3d& p) {
    return std::array<double, 3>{std::floor(p.x() / size), std::floor(p.y() / size), std::floor(p.z() / size)};
  };
  for (const PlacedSurfel& s : surfels) {
    const bool repeated = std::any_of(expected.begin(), expected.end(), [&](const PlacedSurfel& e) {
      return cube(e.mean) == cube(s.mean) && std::acos(std::min(1.0, e.normal.dot(s.normal))) < to_rad(15.0);
    });
    if (!repeated) expected.push_back(s);
  }
  const auto kept = without_repetitions(surfels, size);
  ASSERT_EQ(expected.size(), kept.size());
  ASSERT_LT(kept.size(), surfels.size());
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(expected[i].mean, kept[i].mean);
}

}  // namespace
}  // namespace rigcal
