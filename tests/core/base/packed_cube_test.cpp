#include "core/base/packed_cube.h"

#include <gtest/gtest.h>

#include <array>

namespace rigcal {
namespace {

constexpr std::int64_t most = (1 << 20) - 1;

TEST(PackedCube, GivesItsIndicesBack) {
  const std::array<std::int64_t, 6> values{-most - 1, -17, -1, 0, 5, most};
  for (const std::int64_t x : values) {
    for (const std::int64_t y : values) {
      for (const std::int64_t z : values) {
        const std::uint64_t cube = packed_cube(x, y, z);
        EXPECT_EQ(x, index_of_packed(cube, 0));
        EXPECT_EQ(y, index_of_packed(cube, 1));
        EXPECT_EQ(z, index_of_packed(cube, 2));
      }
    }
  }
}

TEST(PackedCube, StandsInTheOrderOfXThenYThenZ) {
  EXPECT_LT(packed_cube(-1, most, most), packed_cube(0, -most, -most));
  EXPECT_LT(packed_cube(3, -1, most), packed_cube(3, 0, -most));
  EXPECT_LT(packed_cube(3, 2, -1), packed_cube(3, 2, 0));
}

}  // namespace
}  // namespace rigcal
