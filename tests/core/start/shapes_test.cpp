#include "core/start/shapes.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace rigcal {
namespace {

Vector3d somewhere(Random& random, double half_m) {
  Vector3d p;
  for (Eigen::Index k = 0; k < 3; ++k) p[k] = random.uniform(-half_m, half_m);
  return p;
}

// Both where shapes lie close together and where most of the voxels around a place are empty.
TEST(ShapeIndex, FindsTheNearestOfAll) {
  Random random(3);
  for (const double half_m : {0.7, 4.0}) {
    std::vector<LocalShape> shapes(500);
    for (LocalShape& shape : shapes) shape.mean = somewhere(random, half_m);
    const double reach_m = 0.3;
    const ShapeIndex index(shapes, reach_m);
    int found = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vector3d p = somewhere(random, half_m + 0.2);
      double nearest_m = reach_m;
      for (const LocalShape& shape : shapes) nearest_m = std::min(nearest_m, (shape.mean - p).norm());
      const int hit = index.nearest(p);
      ASSERT_EQ(hit >= 0, nearest_m < reach_m) << i;
      if (hit < 0) continue;
      ++found;
      ASSERT_EQ((index[hit].mean - p).norm(), nearest_m) << i;
    }
    EXPECT_GT(found, 20);
    EXPECT_LT(found, 2000);
  }
}

}  // namespace
}  // namespace rigcal
