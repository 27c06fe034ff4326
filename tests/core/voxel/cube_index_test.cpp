#include "core/voxel/cube_index.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/base/random.h"

namespace rigcal {
namespace {

TEST(CubeKey, TellsCubesApartAlsoAcrossZero) {
  const auto key = [](float x, float y, float z) { return cube_key({x, y, z}, 20.0); };
  EXPECT_EQ(key(0.01F, 0.01F, 0.01F), key(0.04F, 0.04F, 0.04F));
  EXPECT_NE(key(0.01F, 0.0F, 0.0F), key(-0.01F, 0.0F, 0.0F));
  EXPECT_NE(key(0.0F, 0.06F, 0.0F), key(0.06F, 0.0F, 0.0F));
  EXPECT_NE(key(0.0F, 0.0F, -0.01F), key(0.0F, -0.01F, 0.0F));
}

TEST(KeyNumbers, GoOnCountingWhileTheTableGrows) {
  KeyNumbers numbers;
  for (std::uint64_t i = 0; i < 5000; ++i) {
    const auto met = numbers.meet(i * i * 977);
    ASSERT_TRUE(met.first);
    ASSERT_EQ(met.number, i);
  }
  for (std::uint64_t i = 0; i < 5000; ++i) {
    const auto met = numbers.meet(i * i * 977);
    ASSERT_FALSE(met.first);
    ASSERT_EQ(met.number, i);
    ASSERT_EQ(numbers.find(i * i * 977), i);
  }
  EXPECT_EQ(numbers.find(5), KeyNumbers::unknown);
  EXPECT_EQ(numbers.size(), 5000U);
}

// Against a plain map from cubes to points, over calls of several chunks.
TEST(CubeIndex, VisitsEveryPointOnceInItsCube) {
  Random random(5);
  CubeIndex index(0.1);
  std::map<std::array<int, 3>, std::pair<std::size_t, std::uint32_t>> known;
  for (int call = 0; call < 3; ++call) {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 40'000; ++i) {
      points.push_back(Eigen::Vector3d(random.normal(), random.normal(), random.normal()).cast<float>());
    }
    struct Answer {
      std::size_t shard;
      std::uint32_t cube;
      bool first;
      int visits;
    };
    std::vector<Answer> answers(points.size(), Answer{});
    index.add(points, [&](std::size_t shard, std::uint32_t cube, std::uint32_t i, bool first) {
      answers[i] = {shard, cube, first, answers[i].visits + 1};
    });
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto part = [](float x) { return static_cast<int>(std::floor(x * 10.0)); };
      const auto [it, first] = known.try_emplace({part(points[i].x()), part(points[i].y()), part(points[i].z())},
                                                 answers[i].shard, answers[i].cube);
      ASSERT_EQ(answers[i].visits, 1);
      ASSERT_EQ(answers[i].first, first);
      ASSERT_EQ(it->second, std::pair(answers[i].shard, answers[i].cube));
    }
  }
  EXPECT_GT(known.size(), 20'000U);
}

}  // namespace
}  // namespace rigcal
