// How long each stop of a calibration that goes on takes (seconds of processor, all threads together), how right its
// estimates are, and how far the last one is from the result on all stops at once. Simulated runs in memory; run by
// hand, see docs/judging.md.
#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "core/pipeline/incremental_calibration.h"
#include "simdata/scene/scene_file.h"
#include "tests/support/light_recording.h"

namespace rigcal {
namespace {

struct TrialOptions {
  std::vector<std::string> scenes{"courtyard", "room", "sparse"};
  int runs = 3;
  int stops = 20;
  int shots = 20000;
  bool without_gyro = false;
};

// The largest of the LiDARs.
struct Worst {
  double mm = 0.0;
  double deg = 0.0;
  double sigmas = 0.0;  ///< Root mean square of the six directions.
  int found = 0;

  void take(const SE3& is, const SE3& should_be, const Matrix6d& covariance) {
    mm = std::max(mm, 1e3 * (is.t - should_be.t).norm());
    deg = std::max(deg, to_deg(rotation_distance(is.R, should_be.R)));
    const Vector6d error = (is.inverse() * should_be).log();
    sigmas = std::max(sigmas, std::sqrt(error.dot(covariance.ldlt().solve(error)) / 6.0));
    ++found;
  }
};

double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

LightRecording recording_of(const sim::Scene& scene, int seed, const TrialOptions& options) {
  sim::LightRigOptions light;
  light.seed = static_cast<std::uint64_t>(seed);
  light.turntable.stops = options.stops;
  light.shots_per_patch = options.shots;
  const sim::LightRig rig = *sim::make_light_rig(scene, light);
  LightRecording run = make_light_recording(rig);
  if (!options.without_gyro) {
    for (std::size_t j = 1; j < run.recording.stops.size(); ++j) {
      run.recording.gyro_turns.resize(run.recording.stops.size());
      run.recording.gyro_turns[j] = GyroTurn{run.rig.base, *run.recording.R_previous_this[j]};
    }
    return run;
  }
  for (auto& R : run.recording.R_previous_this) R.reset();
  run.rig.turntable.emplace().axis = rig.axis;
  return run;
}

void try_one(const std::string& name, int seed, const LightRecording& run) {
  IncrementalOptions options;
  options.goal = {0.005, to_rad(0.05)};
  IncrementalCalibration calibration(run.rig, run.recording.lidar_sensors, run.guess, options);
  SilentReporter silent;
  StopEstimate last;
  double all_s = 0.0;
  double worst_s = 0.0;
  for (CalibrationStop& stop : stops_of(run.recording)) {
    calibration.add_stop(std::move(stop));
    const double begun_s = processor_s();
    auto estimate = calibration.estimate({silent});
    const double took_s = processor_s() - begun_s;
    if (!estimate) {
      std::printf("%s seed %d: %s\n", name.c_str(), seed, estimate.error().message().c_str());
      return;
    }
    last = std::move(*estimate);
    all_s += took_s;
    worst_s = std::max(worst_s, took_s);
    Worst off;
    int good = 0;
    for (std::size_t i = 1; i < last.lidars.size(); ++i) {
      const SensorResult& result = last.lidars[i].result;
      good += result.status == Status::good ? 1 : 0;
      if (result.T_base_sensor) off.take(*result.T_base_sensor, run.truth.T_base_sensor[i], result.covariance);
    }
    const std::vector<char>& known = calibration.solution()->start.stop_known;
    std::printf(
        "  stop %2d: %5.2f s %-8s %d LiDARs (%d good), %7.1f mm, %6.3f deg, %5.1f sigma off; %td stops left out%s\n",
        last.stops, took_s, last.searched ? "searched" : "", off.found, good, off.mm, off.deg, off.sigmas,
        std::count(known.begin(), known.end(), 0), last.reached ? ", reached" : "");
  }
  const double begun_s = processor_s();
  LidarCalibrationOptions at_once;
  at_once.require = options.goal;
  at_once.with_map = false;
  const auto batch = calibrate_lidars(run.rig, run.recording, run.guess, at_once, {silent});
  const double batch_s = processor_s() - begun_s;
  Worst apart;
  Worst off;
  for (std::size_t i = 1; batch && i < last.lidars.size(); ++i) {
    const auto& T = batch->sensors[i].T_base_sensor;
    if (!T) continue;
    off.take(*T, run.truth.T_base_sensor[i], batch->sensors[i].covariance);
    if (last.lidars[i].result.T_base_sensor)
      apart.take(*last.lidars[i].result.T_base_sensor, *T, batch->sensors[i].covariance);
  }
  std::printf(
      "%s seed %d: %.1f s for all estimates, %.2f s at most; at once %.2f s, %d LiDARs, %.1f mm off; the last estimate "
      "is %.2f mm, %.2f sigma from that (%d LiDARs)\n",
      name.c_str(), seed, all_s, worst_s, batch_s, off.found, off.mm, apart.mm, apart.sigmas, apart.found);
  std::fflush(stdout);
}

int run_trials(const TrialOptions& options) {
  for (const std::string& name : options.scenes) {
    const auto scene = sim::load_scene(name);
    if (!scene) {
      std::fprintf(stderr, "incremental_trials: %s\n", scene.error().message().c_str());
      return 3;
    }
    for (int seed = 1; seed <= options.runs; ++seed) try_one(name, seed, recording_of(*scene, seed, options));
  }
  return 0;
}

}  // namespace
}  // namespace rigcal

int main(int argc, char** argv) {
  rigcal::TrialOptions options;
  CLI::App app("Estimates after each stop: their time, and how right they are");
  app.add_option("SCENE", options.scenes, "Scenes (default courtyard room sparse)");
  app.add_option("--runs", options.runs, "Runs of each scene (default 3)");
  app.add_option("--stops", options.stops, "Stops of each run (default 20)");
  app.add_option("--shots", options.shots, "Shots of each patch (default 20000)");
  app.add_flag("--without-gyro", options.without_gyro, "Nothing is known of the turns but the table's axis");
  CLI11_PARSE(app, argc, argv);
  return rigcal::run_trials(options);
}
