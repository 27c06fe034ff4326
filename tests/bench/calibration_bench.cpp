#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "core/base/parallel.h"
#include "core/pipeline/lidar_calibration.h"
#include "core/planes/refine.h"
#include "simdata/scene/scene_file.h"
#include "tests/support/light_recording.h"

// Points to extrinsics, on 20 stops of an AVIA and three MID-40 in the courtyard: 4 million points, or what
// RIGCAL_BENCH_POINTS says (4e7: the size of the paper's largest runs, about 2 GB). All rates are raw points a second.
// Aims on two cores: 1.6e7 points whole in 0.9 s, one joint iteration with re-voxelisation below 0.1 s.
namespace rigcal {
namespace {

// A simulated run, made once.
struct Bench {
  sim::LightRig light;
  LightRecording run;
  std::vector<NoiseModel> noise;
};

std::unique_ptr<Bench> make_bench() {
  const char* wanted = std::getenv("RIGCAL_BENCH_POINTS");
  const double points = wanted != nullptr ? std::max(1e5, std::atof(wanted)) : 4e6;
  sim::LightRigOptions options;
  const int stops = options.turntable.stops;
  options.shots_per_patch = static_cast<int>(points / (4.0 * stops) * 1.2);  // a sixth of the shots sees the sky
  options.turntable.dwell_s = std::max(2.0, options.shots_per_patch / 100e3 + 0.1);  // a MID-40's shots a second
  auto bench = std::make_unique<Bench>();
  bench->light = *sim::make_light_rig(*sim::load_scene("courtyard"), options);
  bench->run = make_light_recording(bench->light);
  bench->noise.assign(bench->light.rig.sensors.size(), NoiseModel{});
  return bench;
}

const Bench& shared() {
  static const std::unique_ptr<Bench> bench = make_bench();
  return *bench;
}

void set_rates(benchmark::State& state, const Bench& bench) {
  state.SetItemsProcessed(state.iterations() * bench.run.points);
  state.counters["points"] = static_cast<double>(bench.run.points);
}

void cells(benchmark::State& state) {
  const Bench& bench = shared();
  set_thread_count(static_cast<int>(state.range(0)));
  std::size_t count = 0;
  for (auto _ : state) {
    count = 0;
    for (const PatchCells& patch : cells_of(bench.light.patches)) count += patch.cells.size();
  }
  set_rates(state, bench);
  state.counters["cells"] = static_cast<double>(count);
}
BENCHMARK(cells)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void voxel_map(benchmark::State& state) {
  const Bench& bench = shared();
  set_thread_count(static_cast<int>(state.range(0)));
  std::size_t planes = 0;
  for (auto _ : state) {
    planes = build_plane_map(bench.run.recording.patches, bench.run.truth, bench.noise, SE3{}, PlaneMapOptions{})
                 .features.size();
  }
  set_rates(state, bench);
  state.counters["planes"] = static_cast<double>(planes);
}
BENCHMARK(voxel_map)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

// The map anew and one step of all poses and extrinsics.
void joint_iteration(benchmark::State& state) {
  const Bench& bench = shared();
  set_thread_count(static_cast<int>(state.range(0)));
  const auto stops = static_cast<int>(bench.run.recording.stops.size());
  const auto lidars = static_cast<int>(bench.run.recording.lidar_sensors.size());
  ParameterLayout layout(stops, lidars);
  for (int j = 1; j < stops; ++j) layout.free_stop(j);
  for (int i = 0; i < lidars; ++i) {
    if (i != bench.run.rig.base) layout.free_lidar(i);
  }
  RefinePass pass = standard_passes(1).back();
  pass.iterations = 1;
  const RefineInput input{bench.run.recording.patches, bench.noise, SE3{}, {}, {}};
  SilentReporter silent;
  std::size_t planes = 0;
  for (auto _ : state) {
    RigState moved = bench.run.truth;
    const auto summary = refine(input, layout, {pass}, {silent}, moved);
    if (!summary) {
      state.SkipWithError(summary.error().message().c_str());
      break;
    }
    planes = summary->map.features.size();
  }
  set_rates(state, bench);
  state.counters["planes"] = static_cast<double>(planes);
}
BENCHMARK(joint_iteration)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

// How long each stage took, and how far the worst sensor is from the truth.
void show(benchmark::State& state, const Bench& bench, const CalibrationResult& result) {
  for (const StageReport& stage : result.stages) state.counters[stage.name + "_ms"] = 1e3 * stage.wall_s;
  double worst = 0.0;
  for (std::size_t k = 0; k < result.sensors.size(); ++k) {
    const auto& T = result.sensors[k].T_base_sensor;
    worst = std::max(worst, T ? (T->t - bench.light.T_base_sensor[k].t).norm() : 1e3);
  }
  state.counters["worst_mm"] = 1e3 * worst;
}

void calibrate(benchmark::State& state, bool from_points) {
  const Bench& bench = shared();
  set_thread_count(static_cast<int>(state.range(0)));
  LidarRecording recording = bench.run.recording;
  SilentReporter silent;
  for (auto _ : state) {
    if (from_points) recording.patches = cells_of(bench.light.patches);
    const auto result =
        calibrate_lidars(bench.run.rig, recording, bench.run.guess, LidarCalibrationOptions{}, {silent});
    if (!result) {
      state.SkipWithError(result.error().message().c_str());
      break;
    }
    show(state, bench, *result);
  }
  set_rates(state, bench);
}
BENCHMARK_CAPTURE(calibrate, from_cells, false)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(calibrate, from_points, true)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace rigcal
