#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "core/base/parallel.h"
#include "core/pipeline/lidar_calibration.h"
#include "core/planes/refine.h"
#include "simdata/light_rig.h"
#include "simdata/scene_file.h"

// Points to extrinsics, on 20 stops of an AVIA and three MID-40 in the courtyard: 4 million points, or what
// RIGCAL_BENCH_POINTS says (4e7: the size of the paper's largest runs, about 2 GB). All rates are raw points a second.
// Aims on two cores: 1.6e7 points whole in 0.9 s, one joint iteration with re-voxelisation below 0.1 s.
namespace rigcal {
namespace {

// A simulated run and what the stages make of it, made once.
struct Bench {
  sim::LightRig light;
  LidarRecording recording;  ///< With the cells.
  std::vector<std::optional<SE3>> guess;
  std::vector<NoiseModel> noise;
  RigState truth;
  std::int64_t points = 0;
};

CellOptions cell_options() {
  CellOptions options;
  options.keep_thinned = true;  // as `calibrate` does
  return options;
}

std::vector<PatchCells> make_cells(const sim::LightRig& light) {
  std::vector<PatchCells> cells(light.patches.size());
  parallel_for(cells.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      CellBuilder builder(light.patches[k].sensor, light.patches[k].stop, cell_options());
      builder.add(light.patches[k].points);
      cells[k] = builder.finish();
    }
  });
  return cells;
}

std::unique_ptr<Bench> make_bench() {
  const char* wanted = std::getenv("RIGCAL_BENCH_POINTS");
  const double points = wanted != nullptr ? std::max(1e5, std::atof(wanted)) : 4e6;
  sim::LightRigOptions options;
  const int stops = options.turntable.stops;
  options.shots_per_patch = static_cast<int>(points / (4.0 * stops) * 1.2);  // a sixth of the shots sees the sky
  options.turntable.dwell_s = std::max(2.0, options.shots_per_patch / 100e3 + 0.1);  // a MID-40's shots a second
  auto bench = std::make_unique<Bench>();
  bench->light = *sim::make_light_rig(*sim::load_scene("courtyard"), options);
  for (const Patch& patch : bench->light.patches) bench->points += static_cast<std::int64_t>(patch.points.size());
  for (std::size_t k = 0; k < bench->light.rig.sensors.size(); ++k) {
    bench->recording.lidar_sensors.push_back(static_cast<int>(k));
    bench->guess.push_back(bench->light.rig.sensors[k].initial_T_base_sensor);
  }
  bench->guess[static_cast<std::size_t>(bench->light.rig.base)] = SE3{};
  bench->noise.assign(bench->light.rig.sensors.size(), NoiseModel{});
  for (int j = 0; j < stops; ++j) bench->recording.stops.push_back({j, 0, 0});
  bench->recording.R_previous_this.resize(static_cast<std::size_t>(stops));
  for (std::size_t j = 1; j < bench->recording.R_previous_this.size(); ++j) {
    bench->recording.R_previous_this[j] = exp_so3(bench->light.step_rotations[j - 1]);
  }
  bench->recording.patches = make_cells(bench->light);
  bench->truth = {bench->light.T_G_base, bench->light.T_base_sensor};
  return bench;
}

const Bench& shared() {
  static const std::unique_ptr<Bench> bench = make_bench();
  return *bench;
}

void set_rates(benchmark::State& state, const Bench& bench) {
  state.SetItemsProcessed(state.iterations() * bench.points);
  state.counters["points"] = static_cast<double>(bench.points);
}

void cells(benchmark::State& state) {
  const Bench& bench = shared();
  set_thread_count(static_cast<int>(state.range(0)));
  std::size_t count = 0;
  for (auto _ : state) {
    count = 0;
    for (const PatchCells& patch : make_cells(bench.light)) count += patch.cells.size();
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
    planes =
        build_plane_map(bench.recording.patches, bench.truth, bench.noise, SE3{}, PlaneMapOptions{}).features.size();
  }
  set_rates(state, bench);
  state.counters["planes"] = static_cast<double>(planes);
}
BENCHMARK(voxel_map)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

// The map anew and one step of all poses and extrinsics.
void joint_iteration(benchmark::State& state) {
  const Bench& bench = shared();
  set_thread_count(static_cast<int>(state.range(0)));
  const auto stops = static_cast<int>(bench.recording.stops.size());
  const auto lidars = static_cast<int>(bench.recording.lidar_sensors.size());
  ParameterLayout layout(stops, lidars);
  for (int j = 1; j < stops; ++j) layout.free_stop(j);
  for (int i = 0; i < lidars; ++i) {
    if (i != bench.light.rig.base) layout.free_lidar(i);
  }
  RefinePass pass = standard_passes(1).back();
  pass.iterations = 1;
  const RefineInput input{bench.recording.patches, bench.noise, SE3{}, {}, {}};
  SilentReporter silent;
  std::size_t planes = 0;
  for (auto _ : state) {
    RigState moved = bench.truth;
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
  LidarRecording recording = bench.recording;
  SilentReporter silent;
  for (auto _ : state) {
    if (from_points) recording.patches = make_cells(bench.light);
    const auto result = calibrate_lidars(bench.light.rig, recording, bench.guess, LidarCalibrationOptions{}, {silent});
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
