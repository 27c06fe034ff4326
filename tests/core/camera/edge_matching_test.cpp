#include "core/camera/edge_matching.h"

#include <gtest/gtest.h>

#include "tests/core/camera/box_room.h"

namespace rigcal {
namespace {

const BoxRoom& room() {
  static const BoxRoom room;
  return room;
}

std::vector<ImageEdge> vertical_edge(float x, float y0, float y1, int chain) {
  std::vector<ImageEdge> edges;
  for (float y = y0; y <= y1; y += 1.0F) edges.push_back({{x, y}, {1.0F, 0.0F}, chain});
  return edges;
}

TEST(EdgeIndex, FindsWhatLiesAround) {
  std::vector<ImageEdge> edges = vertical_edge(100.3F, 10.0F, 60.0F, 0);
  const std::vector<ImageEdge> others = vertical_edge(639.4F, 0.0F, 479.0F, 1);
  edges.insert(edges.end(), others.begin(), others.end());
  const EdgeIndex index(640, 480, edges);
  EXPECT_EQ(index.size(), edges.size());
  int found = 0;
  index.around({104.0, 30.0}, {6.0, 2.0}, [&](const ImageEdge& edge) {
    EXPECT_EQ(edge.chain, 0);
    if (std::abs(edge.position.y() - 30.0F) <= 2.0F) ++found;
  });
  EXPECT_EQ(found, 5);
  index.around({300.0, 30.0}, {50.0, 50.0}, [&](const ImageEdge&) { ADD_FAILURE(); });
  index.around({-500.0, 9000.0}, {50.0, 50.0}, [&](const ImageEdge&) { ADD_FAILURE(); });
  found = 0;
  index.around({660.0, 479.0}, {30.0, 0.0}, [&](const ImageEdge&) { ++found; });
  EXPECT_GT(found, 0);
}

// A camera at the origin that looks along z at a vertical line through the middle of its image, 4 m away.
class EdgeMatchingTest : public testing::Test {
 protected:
  EdgeMatchingTest() : camera_(camera_at(CameraModel(intrinsics_), {}, {})) {
    for (int k = 0; k < 20; ++k) {
      LidarEdge edge;
      edge.p_G = Vector3d(0.0, -0.5 + 0.05 * k, 4.0);
      edge.direction_G = Vector3d::UnitY();
      edge.covariance_G = 1e-6 * Vector3d(1.0, 0.0, 1.0).asDiagonal();
      scene_.edges.push_back(edge);
      view_.samples.push_back(static_cast<std::uint32_t>(k));
    }
    view_.segments = {{0, 0, 20}};
    wide_.gate_px = 3.0;
    wide_.scale_px = 0.7;
  }
  SegmentFit match(const std::vector<ImageEdge>& edges, const MatchOptions& options) {
    view_.index = EdgeIndex(640, 480, edges);
    return match_view(scene_, view_, camera_, options).front();
  }

  CameraIntrinsics intrinsics_{DistortionModel::radtan, 640, 480, 500.0, 500.0, 320.0, 240.0, {0, 0, 0, 0, 0}};
  CameraAtStop camera_;
  CameraScene scene_;
  EdgeView view_;
  MatchOptions wide_;
};

TEST_F(EdgeMatchingTest, MeasuresTheOffsetOfASegment) {
  const SegmentFit fit = match(vertical_edge(321.5F, 100.0F, 400.0F, 0), wide_);
  EXPECT_EQ(fit.samples, 20);
  EXPECT_EQ(fit.matched, 20);
  EXPECT_NEAR(fit.offset_px, -1.5, 1e-5);
  // 0.2 px, and half a millimetre at 4 m: 125 pixels a metre.
  EXPECT_NEAR(fit.sigma_px, std::hypot(0.2, 0.0625), 1e-9);
  EXPECT_NEAR(fit.expected_px, std::hypot(fit.sigma_px, 125.0 * std::hypot(0.0015, 4.0 * 0.0003)), 1e-3);
  EXPECT_LT(fit.robust, 0.2);
  EXPECT_GT(match(vertical_edge(320.1F, 100.0F, 400.0F, 0), wide_).robust, 0.9);
}

TEST_F(EdgeMatchingTest, GatesByDistanceAndDirection) {
  EXPECT_EQ(match(vertical_edge(324.0F, 100.0F, 400.0F, 0), wide_).weight, 0.0);
  std::vector<ImageEdge> slanted = vertical_edge(320.5F, 100.0F, 400.0F, 0);
  for (ImageEdge& edge : slanted) edge.normal = {std::cos(0.35F), std::sin(0.35F)};
  EXPECT_EQ(match(slanted, wide_).weight, 0.0);
  for (ImageEdge& edge : slanted) edge.normal = {-std::cos(0.1F), -std::sin(0.1F)};  // which side is bright is open
  EXPECT_GT(match(slanted, wide_).share(), 0.8);
}

TEST_F(EdgeMatchingTest, SharesASampleAmongItsCandidatesAndClutter) {
  std::vector<ImageEdge> edges = vertical_edge(321.0F, 100.0F, 400.0F, 0);
  const std::vector<ImageEdge> other = vertical_edge(319.0F, 100.0F, 400.0F, 1);
  edges.insert(edges.end(), other.begin(), other.end());
  const SegmentFit both = match(edges, wide_);
  EXPECT_NEAR(both.offset_px, 0.0, 1e-5);
  EXPECT_LE(both.weight, 20.0);
  std::vector<EdgeMatch> matches;
  (void)match_view(scene_, view_, camera_, wide_, &matches);
  EXPECT_EQ(matches.size(), 40U);
  // A lone partner far off is rather clutter.
  MatchOptions sharp;
  sharp.scale_px = 0.5;
  EXPECT_LT(match(vertical_edge(322.5F, 100.0F, 400.0F, 0), sharp).share(), 0.05);
}

TEST(EdgeViews, SeesWhatNothingHides) {
  CameraTask task{0, "camera", BoxRoom::intrinsics(), BoxRoom::truth(), {}};
  const CameraModel model(task.intrinsics);
  std::vector<EdgeView> views(BoxRoom::stops);
  for (int j = 0; j < BoxRoom::stops; ++j) views[static_cast<std::size_t>(j)].stop = j;
  find_visible(room().scene, task.intrinsics, {BoxRoom::truth()}, VisibleOptions{}, views);
  std::size_t seen = 0;
  std::size_t wrong = 0;
  for (const EdgeView& view : views) {
    const SE3 T_G_C = room().scene.T_G_base[static_cast<std::size_t>(view.stop)] * BoxRoom::truth();
    EXPECT_FALSE(view.segments.empty());
    int line = -1;
    for (const EdgeSegment& segment : view.segments) {
      EXPECT_GT(segment.line, line);
      line = segment.line;
      for (std::uint32_t k = segment.begin; k < segment.end; ++k) {
        const LidarEdge& edge = room().scene.edges[view.samples[k]];
        EXPECT_EQ(edge.line, line);
        const Vector3d d = edge.p_G - T_G_C.t;
        const auto pixel = model.project(T_G_C.R.transpose() * d);
        ASSERT_TRUE(pixel);
        EXPECT_TRUE(model.contains(*pixel));
        ++seen;
        // More than the depth buffer's tolerance behind something.
        if (room().range(T_G_C.t, d.normalized()) < 0.98 * d.norm() - 0.2) ++wrong;
      }
    }
  }
  EXPECT_GT(seen, 1000U);
  EXPECT_LT(wrong, seen / 50);
}

}  // namespace
}  // namespace rigcal
