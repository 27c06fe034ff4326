#include "core/camera/depth_buffer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/camera/sample_blocks.h"
#include "tests/support/pinhole.h"

namespace rigcal {
namespace {

constexpr double far_m = 1e6;

// On no plane: whatever is nearer hides it.
const MapSample loose;

// A wall across the view at z, from x0 to x1, with a sample each 5 cm.
void add_wall(double z, double x0, double x1, std::vector<MapSample>& samples) {
  for (double x = x0; x <= x1; x += 0.05) {
    for (double y = -3.0; y <= 3.0; y += 0.05) {
      MapSample s;
      s.p_G = Vector3d(x, y, z).cast<float>();
      s.normal_G = Eigen::Vector3f(0.0F, 0.0F, -1.0F);
      samples.push_back(s);
    }
  }
}

class DepthBufferTest : public testing::Test {
 protected:
  void SetUp() override {
    add_wall(6.0, -6.0, 6.0, samples_);
    add_wall(3.0, -3.0, 0.0, samples_);  // hides the left half of the other
  }
  [[nodiscard]] Eigen::Vector2d pixel(const Vector3d& p) const { return *model_.project(p); }

  CameraModel model_{pinhole(640, 480, 500.0)};
  std::vector<MapSample> samples_;
};

TEST_F(DepthBufferTest, SeesTheNearestSurfaceAndNotWhatItHides) {
  const DepthBuffer buffer(model_, SE3{}, samples_);
  const Vector3d front(-1.0, 0.2, 3.0);
  const Vector3d behind(-2.0, 0.4, 6.0);
  const Vector3d open(1.5, 0.4, 6.0);
  EXPECT_TRUE(buffer.sees(pixel(front), front.norm(), loose));
  EXPECT_FALSE(buffer.sees(pixel(behind), behind.norm(), loose));
  EXPECT_TRUE(buffer.sees(pixel(open), open.norm(), loose));
  EXPECT_FALSE(buffer.sees(pixel(behind), 0.58 * behind.norm(), loose)) << "the near wall, and what it may be off by";
  EXPECT_TRUE(buffer.sees(pixel(behind), 0.5 * behind.norm(), loose));
}

TEST_F(DepthBufferTest, FacesOfAnEdgeDoNotHideIt) {
  const DepthBuffer buffer(model_, SE3{}, samples_);
  LidarEdge edge;
  edge.p_G = Vector3d(-2.0, 0.4, 6.0);
  edge.normal_a_G = Vector3d::UnitX();
  edge.normal_b_G = Vector3d::UnitY();
  EXPECT_FALSE(buffer.sees(pixel(edge.p_G), edge.p_G.norm(), edge));
  // The near wall passes through the point's pixel at (-1, 0.2, 3); a face that holds that place is the edge's own.
  edge.normal_a_G = (edge.p_G - Vector3d(-1.0, 0.2, 3.0)).cross(Vector3d::UnitY()).normalized();
  EXPECT_TRUE(buffer.sees(pixel(edge.p_G), edge.p_G.norm(), edge));
}

// Far away a cell has metres of a floor in it.
TEST(DepthBuffer, AFloorDoesNotHideItselfHoweverFlatTheCameraLooksAlongIt) {
  const CameraModel model(pinhole(320, 240, 200.0));
  std::vector<MapSample> floor;
  for (double x = -4.0; x <= 4.0; x += 0.05) {
    for (double z = 2.0; z <= 15.0; z += 0.05)
      floor.push_back({Vector3d(x, 1.0, z).cast<float>(), -Eigen::Vector3f::UnitY(), 0, 0});
  }
  const DepthBuffer buffer(model, SE3{}, floor);
  for (const MapSample& sample : floor) {
    const Vector3d p = sample.p_G.cast<double>();
    ASSERT_TRUE(buffer.sees(*model.project(p), p.norm(), sample)) << p.transpose();
  }
}

TEST_F(DepthBufferTest, KnowsSilhouettes) {
  const DepthBuffer buffer(model_, SE3{}, samples_);
  const Vector3d at_border(-0.02, 0.0, 3.0);
  const Vector3d inside(-1.0, 0.0, 3.0);
  const MapSample near_wall = samples_.back();
  EXPECT_TRUE(buffer.near_silhouette(pixel(at_border), at_border.norm(), near_wall, 2));
  EXPECT_FALSE(buffer.near_silhouette(pixel(inside), inside.norm(), near_wall, 2));
}

TEST_F(DepthBufferTest, EmptyWithoutAMapAndBehindTheCamera) {
  const DepthBuffer none(model_, SE3{}, {});
  EXPECT_TRUE(none.sees({10.0, 10.0}, far_m, loose));
  EXPECT_TRUE(none.sees({-50.0, 9999.0}, far_m, loose));
  SE3 turned;
  turned.R = exp_so3(Vector3d(0.0, to_rad(180.0), 0.0));
  const DepthBuffer behind(model_, turned, samples_);
  for (int y = 0; y < 480; y += 4) {
    for (int x = 0; x < 640; x += 4) ASSERT_TRUE(behind.sees({x + 1.5, y + 1.5}, far_m, loose));
  }
}

// What a sample covers, written cell by cell.
TEST_F(DepthBufferTest, CoversTheSameCellsAsSampleBySample) {
  const CameraModel model(pinhole(160, 120, 100.0));
  Random random(3);
  std::vector<MapSample> samples;
  for (int i = 0; i < 3000; ++i) {
    const double range = random.uniform(0.05, 8.0);
    const Vector3d ray(random.uniform(-0.85, 0.85), random.uniform(-0.65, 0.65), 1.0);
    MapSample sample;
    sample.p_G = (range * ray).cast<float>();
    samples.push_back(sample);
  }
  constexpr int cell = 4;
  std::vector<double> nearest(40 * 30, 0.0);
  for (const MapSample& sample : samples) {
    const Vector3d p = sample.p_G.cast<double>();
    const Eigen::Vector2d at = *model.project(p);
    const int reach =
        std::clamp(static_cast<int>(std::ceil((0.5 * 100.0 * 0.05 / p.norm() - 0.5 * cell) / cell)), 0, 12);
    const int c = static_cast<int>(std::floor((at.x() + 0.5) / cell));
    const int r = static_cast<int>(std::floor((at.y() + 0.5) / cell));
    for (int y = std::max(0, r - reach); y <= std::min(29, r + reach); ++y) {
      for (int x = std::max(0, c - reach); x <= std::min(39, c + reach); ++x) {
        double& e = nearest[static_cast<std::size_t>(40 * y + x)];
        if (e == 0.0 || p.norm() < e) e = p.norm();
      }
    }
  }
  DepthBufferOptions exact;
  exact.tolerance_m = 0.0;
  exact.tolerance_per_m = 0.0;
  const std::vector<SampleBlock> blocks = blocks_of(samples, 0.5);
  const DepthBuffer all(model, SE3{}, samples, {}, exact);
  const DepthBuffer in_blocks(model, SE3{}, samples, blocks, exact);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      // Of the cells around it as well; far away where nothing is.
      double range = far_m;
      for (int r = std::max(0, y - 1); r <= std::min(29, y + 1); ++r) {
        for (int c = std::max(0, x - 1); c <= std::min(39, x + 1); ++c) {
          const double here = nearest[static_cast<std::size_t>(40 * r + c)];
          if (here > 0.0) range = std::min(range, here);
        }
      }
      const Eigen::Vector2d at(cell * x + 1.5, cell * y + 1.5);
      for (const DepthBuffer* buffer : {&all, &in_blocks}) {
        ASSERT_TRUE(buffer->sees(at, range - 1e-5, loose)) << x << " " << y;
        ASSERT_EQ(buffer->sees(at, range + 1e-5, loose), range == far_m) << x << " " << y;
      }
    }
  }
}

}  // namespace
}  // namespace rigcal
