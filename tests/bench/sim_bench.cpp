#include <benchmark/benchmark.h>

#include "core/base/parallel.h"
#include "simdata/packets/run_stream.h"
#include "simdata/rig/light_rig.h"
#include "simdata/scene/scene_file.h"

// Shots per second of the simulator; one shot of all devices counts the same. Aim: 2 M/s on two cores.
namespace rigcal::sim {
namespace {

const char* const scenes[] = {"courtyard", "room", "sparse"};

// Whole runs: rays, noise, packets, merging; argument 0: scene, argument 1: threads.
void stream_run(benchmark::State& state) {
  const auto scene = load_scene(scenes[state.range(0)]);
  set_thread_count(static_cast<int>(state.range(1)));
  RunOptions options;
  options.turntable.stops = 2;
  SilentReporter silent;
  std::int64_t bytes = 0;
  double shots = 0.0;
  for (auto _ : state) {
    const auto truth = simulate_run(*scene, nominal_rig(), options,
                                    [&](const Datagram& datagram) -> Expected<void> {
                                      bytes += static_cast<std::int64_t>(datagram.bytes.size());
                                      return {};
                                    },
                                    {silent});
    shots += static_cast<double>(truth->end_ns - truth->sampling_ns) * 1e-9 * (240e3 + 3 * 100e3);
  }
  state.SetBytesProcessed(bytes);
  state.counters["shots/s"] = benchmark::Counter(shots, benchmark::Counter::kIsRate);
  state.SetLabel(scenes[state.range(0)]);
}
BENCHMARK(stream_run)->ArgsProduct({{0, 1, 2}, {1, 2}})->Unit(benchmark::kMillisecond)->UseRealTime();

// Patches in memory; argument: shots a patch.
void light_rig(benchmark::State& state) {
  const auto scene = load_scene("courtyard");
  set_thread_count(2);
  LightRigOptions options;
  options.shots_per_patch = static_cast<int>(state.range(0));
  options.turntable.stops = 8;
  for (auto _ : state) benchmark::DoNotOptimize(make_light_rig(*scene, options));
  state.counters["shots/s"] = benchmark::Counter(8.0 * 4.0 * static_cast<double>(state.range(0)),
                                                 benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(light_rig)->Arg(20000)->Unit(benchmark::kMillisecond)->UseRealTime();

// Rays alone, one thread.
void cast_rays(benchmark::State& state) {
  const auto scene = load_scene(scenes[state.range(0)]);
  const RayCaster caster(*scene);
  Random random(1);
  const PrismScanner scanner = *PrismScanner::of(LidarModel::livox_avia, random);
  std::vector<Vector3d> directions(96);
  std::int64_t shot = 0;
  for (auto _ : state) {
    scanner.directions(shot, directions);
    shot += 96;
    for (const Vector3d& direction : directions)
      benchmark::DoNotOptimize(caster.cast(scene->T_scene_table.t, direction, {}, 450.0));
  }
  state.SetItemsProcessed(state.iterations() * 96);
  state.SetLabel(scenes[state.range(0)]);
}
BENCHMARK(cast_rays)->DenseRange(0, 2);

void scan_directions(benchmark::State& state) {
  Random random(1);
  const PrismScanner scanner = *PrismScanner::of(LidarModel::livox_avia, random);
  std::vector<Vector3d> directions(96);
  std::int64_t shot = 0;
  for (auto _ : state) {
    scanner.directions(shot, directions);
    shot += 96;
    benchmark::DoNotOptimize(directions.data());
  }
  state.SetItemsProcessed(state.iterations() * 96);
}
BENCHMARK(scan_directions);

}  // namespace
}  // namespace rigcal::sim
