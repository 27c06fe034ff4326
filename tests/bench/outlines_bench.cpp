#include <benchmark/benchmark.h>

#include <memory>

#include "core/base/parallel.h"
#include "core/edges/outlines.h"
#include "core/edges/step_lines.h"
#include "simdata/scene/scene_file.h"
#include "tests/support/light_recording.h"

// Outlines of surfaces in patches of 200 000 points, of an AVIA and three MID-40 in the courtyard. Rates are raw points
// a second.
namespace rigcal {
namespace {

struct Bench {
  std::vector<PatchCells> patches;
  std::int64_t points = 0;
};

std::unique_ptr<Bench> make_bench() {
  sim::LightRigOptions options;
  options.turntable.stops = 4;
  options.turntable.dwell_s = 2.5;
  options.shots_per_patch = 240'000;  // a sixth of the shots sees the sky
  const sim::LightRig light = *sim::make_light_rig(*sim::load_scene("courtyard"), options);
  const LightRecording run = make_light_recording(light);
  return std::make_unique<Bench>(Bench{run.recording.patches, run.points});
}

const Bench& shared() {
  static const std::unique_ptr<Bench> bench = make_bench();
  return *bench;
}

void depth_steps(benchmark::State& state) {
  const Bench& bench = shared();
  std::size_t steps = 0;
  std::size_t thinned = 0;
  for (auto _ : state) {
    steps = 0;
    thinned = 0;
    for (const PatchCells& patch : bench.patches) {
      thinned += patch.thinned.size();
      for (const std::vector<DepthStep>& face : find_depth_steps(patch.thinned)) steps += face.size();
    }
  }
  state.SetItemsProcessed(state.iterations() * bench.points);
  state.counters["steps"] = static_cast<double>(steps);
  state.counters["thinned"] = static_cast<double>(thinned);
}
BENCHMARK(depth_steps)->Unit(benchmark::kMillisecond);

void outlines(benchmark::State& state) {
  const Bench& bench = shared();
  set_thread_count(static_cast<int>(state.range(0)));
  std::size_t lines = 0;
  std::vector<PatchOutlines> found(bench.patches.size());
  for (auto _ : state) {
    lines = 0;
    parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) found[k] = find_patch_outlines(bench.patches[k], {});
    });
    for (const PatchOutlines& patch : found) {
      for (const std::vector<StepLine>& face : patch.lines) lines += face.size();
    }
  }
  state.SetItemsProcessed(state.iterations() * bench.points);
  state.counters["lines"] = static_cast<double>(lines);
}
BENCHMARK(outlines)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace rigcal
