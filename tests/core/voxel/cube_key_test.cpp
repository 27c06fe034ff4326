#include "core/voxel/cube_key.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

TEST(CubeKey, TellsCubesApartAlsoAcrossZero) {
  const auto key = [](float x, float y, float z) { return cube_key({x, y, z}, 20.0); };
  EXPECT_EQ(key(0.01F, 0.01F, 0.01F), key(0.04F, 0.04F, 0.04F));
  EXPECT_NE(key(0.01F, 0.0F, 0.0F), key(-0.01F, 0.0F, 0.0F));
  EXPECT_NE(key(0.0F, 0.06F, 0.0F), key(0.06F, 0.0F, 0.0F));
  EXPECT_NE(key(0.0F, 0.0F, -0.01F), key(0.0F, -0.01F, 0.0F));
}

}  // namespace
}  // namespace rigcal
