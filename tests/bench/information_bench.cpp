#include <benchmark/benchmark.h>

#include "core/base/parallel.h"
#include "core/camera/information.h"
#include "core/camera/information_cost.h"
#include "core/camera/information_images.h"
#include "tests/core/camera/textured_room.h"

// The information distance of a camera in a painted room, on images of 320 x 240. Aim: at most 75 ns a sighting, basin
// and refinement each well below a second on two cores.
namespace rigcal {
namespace {

const TexturedRoom& room() {
  static const TexturedRoom shared = make_textured_room();
  return shared;
}

// A guess 5 degrees and 0.1 m off.
SE3 guess() { return {room().truth.R * exp_so3({0.05, -0.05, 0.05}), room().truth.t + Vector3d(0.06, 0.06, -0.05)}; }

void sightings(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(0)));
  const SurfaceCodes codes = surface_codes(room().scene.samples);
  const CameraModel model(room().camera.intrinsics);
  for (auto _ : state) {
    benchmark::DoNotOptimize(find_sightings(room().scene, codes, room().camera, model, room().truth, {}));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(room().scene.samples.size()) * 4);
}
BENCHMARK(sightings)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

// The distance at one pose, with its derivatives or without.
void distance(benchmark::State& state, bool derivatives) {
  set_thread_count(1);
  const SurfaceCodes codes = surface_codes(room().scene.samples);
  const CameraModel model(room().camera.intrinsics);
  const std::vector<Sighting> seen = find_sightings(room().scene, codes, room().camera, model, room().truth, {});
  const std::vector<SmoothImage> images = information_images(room().scene, room().camera, 0, Shown::contrast);
  const InformationCost cost(model, seen, images);
  for (auto _ : state) {
    if (derivatives) {
      benchmark::DoNotOptimize(cost.derivatives(room().truth));
    } else {
      benchmark::DoNotOptimize(cost.value(room().truth));
    }
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(seen.size()));
}
BENCHMARK_CAPTURE(distance, alone, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(distance, with_derivatives, true)->Unit(benchmark::kMillisecond);

void basin(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(0)));
  SilentReporter silent;
  for (auto _ : state) {
    benchmark::DoNotOptimize(search_information(room().scene, room().camera, guess(), {}, {silent}));
  }
}
BENCHMARK(basin)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void refinement(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(0)));
  SilentReporter silent;
  const auto found = search_information(room().scene, room().camera, guess(), {}, {silent});
  if (!found) {
    state.SkipWithError("no basin was found");
    return;
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        refine_information(room().scene, room().camera, room().camera.intrinsics, found->best.T_base_camera, {silent}));
  }
}
BENCHMARK(refinement)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace rigcal
