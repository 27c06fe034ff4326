#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/camera/edge_solver.h"

// Single steps of a camera. What a whole camera costs is told by `rigcal experiment speed --part programs`.
namespace rigcal {
namespace {

constexpr int images = 40;
constexpr int lines = 2400;
constexpr int points_of_line = 25;  // 6e4 points in all

CameraIntrinsics intrinsics() {
  return {DistortionModel::radtan, 1280, 1024, 863.0, 863.0, 639.5, 511.5, {-0.10, 0.09, 0.0003, -0.0002, 0.0}};
}

SE3 camera_pose() {
  SE3 T;
  T.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T;
}

// Rectangles of all sizes on each other, with noise: about as many edge pixels as a courtyard shows.
GreyImage picture(std::uint64_t seed) {
  const CameraIntrinsics in = intrinsics();
  Random random(seed);
  GreyImage out{in.width, in.height, std::vector<float>(static_cast<std::size_t>(in.width * in.height), 90.0F)};
  for (int k = 0; k < 260; ++k) {
    const int x0 = static_cast<int>(random.below(static_cast<std::uint64_t>(in.width)));
    const int y0 = static_cast<int>(random.below(static_cast<std::uint64_t>(in.height)));
    const int x1 = std::min(in.width, x0 + 20 + static_cast<int>(random.below(250)));
    const int y1 = std::min(in.height, y0 + 20 + static_cast<int>(random.below(250)));
    const auto grey = static_cast<float>(random.uniform(20.0, 230.0));
    for (int y = y0; y < y1; ++y) {
      std::fill(out.values.begin() + y * in.width + x0, out.values.begin() + y * in.width + x1, grey);
    }
  }
  out = blurred(out, 0.7);
  for (float& v : out.values) v += 1.5F * static_cast<float>(random.normal());
  return out;
}

struct Rig {
  CameraScene scene;
  CameraTask task{0, "camera", intrinsics(), camera_pose(), {}};

  Rig() {
    set_thread_count(2);
    Random random(7);
    for (int j = 0; j < images; ++j) {
      SE3 T;
      T.R = exp_so3(Vector3d(0.0, 0.0, 2.0 * pi * j / images));
      scene.T_G_base.push_back(T);
      scene.stop_known.push_back(1);
      task.views.push_back({j, {}, picture(static_cast<std::uint64_t>(j))});
    }
    const auto direction = [&] {
      return Vector3d(Vector3d(random.normal(), random.normal(), random.normal()).normalized());
    };
    for (int line = 0; line < lines; ++line) {
      Vector3d middle = random.uniform(3.0, 15.0) * direction();
      middle.z() *= 0.4;
      LidarEdge edge;
      edge.line = line;
      edge.direction_G = line % 2 != 0 ? Vector3d(Vector3d::UnitZ()) : middle.cross(Vector3d::UnitZ()).normalized();
      edge.covariance_G = 1e-6 * Matrix3d::Identity();
      for (int k = 0; k < points_of_line; ++k) {
        edge.p_G = middle + 0.025 * (k - 0.5 * points_of_line) * edge.direction_G;
        scene.edges.push_back(edge);
      }
    }
    for (int k = 0; k < 500'000; ++k) {
      MapSample sample;
      sample.p_G = (20.0 * direction()).cast<float>();
      scene.samples.push_back(sample);
    }
  }
};

const Rig& rig() {
  static const Rig rig;
  return rig;
}

void image_edges(benchmark::State& state) {
  const GreyImage& image = rig().task.views.front().grey;
  std::size_t found = 0;
  for (auto _ : state) found = find_image_edges(image).size();
  state.counters["edge_pixels"] = static_cast<double>(found);
}

void one_iteration(benchmark::State& state) {
  const CameraState start{camera_pose()};
  std::vector<EdgeView> views = make_edge_views(rig().scene, rig().task);
  find_visible(rig().scene, rig().task.intrinsics, start, VisibleOptions{}, views);
  MatchOptions options;
  options.gate_px = static_cast<double>(state.range(0));
  for (auto _ : state) {
    benchmark::DoNotOptimize(sum_segments(rig().scene, rig().task.intrinsics, start, options, views));
  }
}

BENCHMARK(image_edges)->Unit(benchmark::kMillisecond);
BENCHMARK(one_iteration)->Arg(3)->Arg(12)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace rigcal
