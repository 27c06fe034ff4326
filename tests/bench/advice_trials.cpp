// How many stops a rig needs until every LiDAR is as sure as asked for: when the table goes where `calibrate
// --incremental` advises, and when it goes on by 22.5 degrees each time. Simulated runs in memory; run by hand, see
// docs/judging.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "apps/common/tolerance.h"
#include "core/pipeline/incremental_calibration.h"
#include "simdata/scene/scene_file.h"
#include "tests/support/light_recording.h"

namespace rigcal {
namespace {

struct AdviceOptions {
  std::vector<std::string> scenes{"courtyard", "room", "sparse"};
  int runs = 5;
  int shots = 20000;
  std::string goal = "2mm,0.02deg";
};

// All places that the table may be sent to, evenly round, and what is seen there.
class Table {
 public:
  Table(const sim::Scene& scene, int places, std::uint64_t seed, int shots) {
    sim::LightRigOptions options;
    options.seed = seed;
    options.turntable.stops = places;
    options.turntable.step_sigma_deg = 0.0;
    options.shots_per_patch = shots;
    run_ = make_light_recording(*sim::make_light_rig(scene, options));
    stops_ = stops_of(run_.recording);
  }

  [[nodiscard]] const LightRecording& run() const { return run_; }
  [[nodiscard]] std::size_t places() const { return stops_.size(); }

  // What comes in when the table goes from one place to another.
  [[nodiscard]] CalibrationStop go(std::size_t from, std::size_t to) const {
    CalibrationStop stop = stops_[to];
    Matrix3d R = Matrix3d::Identity();
    for (std::size_t k = std::min(from, to); k < std::max(from, to); ++k) R = R * *stops_[k + 1].R_previous_this;
    stop.R_previous_this = from < to ? R : Matrix3d(R.transpose());
    return stop;
  }

 private:
  LightRecording run_;
  std::vector<CalibrationStop> stops_;
};

// The place that the advice wants most among those where the rig has not been.
std::size_t advised(const StopAdvice& advice, std::size_t at, const std::vector<char>& visited) {
  const auto places = static_cast<double>(visited.size());
  std::size_t best = visited.size();
  double least = 0.0;
  for (const TurnCandidate& turn : advice.turns) {
    const auto steps = static_cast<std::size_t>(std::lround(turn.angle_rad / (2.0 * pi) * places));
    const std::size_t place = (at + steps) % visited.size();
    if (visited[place] || (best < visited.size() && turn.after.of_goal >= least)) continue;
    best = place;
    least = turn.after.of_goal;
  }
  return best;
}

struct Outcome {
  std::size_t stops = 0;  ///< Until the goal; 0: never.
  double worst_mm = 0.0;  ///< True error then.
};

Outcome drive(const Table& table, const Requirement& goal, bool by_advice) {
  IncrementalOptions options;
  options.goal = goal;
  options.advise = by_advice;
  const LightRecording& run = table.run();
  IncrementalCalibration calibration(run.rig, run.recording.lidar_sensors, run.guess, options);
  std::vector<char> visited(table.places(), 0);
  std::size_t at = 0;
  std::size_t from = 0;
  SilentReporter silent;
  for (std::size_t count = 1; count <= table.places(); ++count) {
    visited[at] = 1;
    calibration.add_stop(table.go(from, at));
    const auto estimate = calibration.estimate({silent});
    if (!estimate) return {};
    if (estimate->reached) {
      Outcome out{count, 0.0};
      for (std::size_t i = 0; i < estimate->lidars.size(); ++i) {
        const double error = (estimate->lidars[i].result.T_base_sensor->t - run.truth.T_base_sensor[i].t).norm();
        out.worst_mm = std::max(out.worst_mm, 1e3 * error);
      }
      return out;
    }
    from = at;
    const std::size_t next = estimate->advice ? advised(*estimate->advice, at, visited) : table.places();
    at = next < table.places() ? next : (at + 1) % table.places();
    if (visited[at]) return {};
  }
  return {};
}

using Outcomes = std::vector<Outcome>;

// A goal that was not reached counts as more stops than any.
std::size_t stops_of(const Outcome& outcome) { return outcome.stops > 0 ? outcome.stops : 1000; }

int count_fewer(const Outcomes& a, const Outcomes& b) {
  int count = 0;
  for (std::size_t k = 0; k < a.size(); ++k) count += stops_of(a[k]) < stops_of(b[k]) ? 1 : 0;
  return count;
}

std::string summary_of(const Outcomes& outcomes) {
  std::vector<std::size_t> stops;
  double worst_mm = 0.0;
  for (const Outcome& outcome : outcomes) {
    if (outcome.stops == 0) continue;
    stops.push_back(outcome.stops);
    worst_mm = std::max(worst_mm, outcome.worst_mm);
  }
  if (stops.empty()) return "never reached";
  std::sort(stops.begin(), stops.end());
  char text[120];
  std::snprintf(text, sizeof text, "%zu stops (median; %zu to %zu, reached in %zu), at most %.1f mm off",
                stops[stops.size() / 2], stops.front(), stops.back(), stops.size(), worst_mm);
  return text;
}

int run_trials(const AdviceOptions& options) {
  const auto tolerance = parse_tolerance(options.goal);
  if (!tolerance) {
    std::fprintf(stderr, "advice_trials: %s\n", tolerance.error().message().c_str());
    return 2;
  }
  const Requirement goal{tolerance->translation_m, tolerance->rotation_rad};
  for (const std::string& name : options.scenes) {
    const auto scene = sim::load_scene(name);
    if (!scene) {
      std::fprintf(stderr, "advice_trials: %s\n", scene.error().message().c_str());
      return 3;
    }
    Outcomes told;
    Outcomes fixed;
    for (int seed = 1; seed <= options.runs; ++seed) {
      const auto number = static_cast<std::uint64_t>(seed);
      fixed.push_back(drive(Table(*scene, 16, number, options.shots), goal, false));
      told.push_back(drive(Table(*scene, 24, number, options.shots), goal, true));
      std::printf("%s seed %d: by advice %zu stops (%.1f mm off), by 22.5 degrees %zu stops (%.1f mm off)\n",
                  name.c_str(), seed, told.back().stops, told.back().worst_mm, fixed.back().stops,
                  fixed.back().worst_mm);
      std::fflush(stdout);
    }
    std::printf("%s, %d runs to %s: by advice %s; by 22.5 degrees %s; fewer by advice in %d, more in %d\n",
                name.c_str(), options.runs, options.goal.c_str(), summary_of(told).c_str(), summary_of(fixed).c_str(),
                count_fewer(told, fixed), count_fewer(fixed, told));
  }
  return 0;
}

}  // namespace
}  // namespace rigcal

int main(int argc, char** argv) {
  rigcal::AdviceOptions options;
  CLI::App app("Stops to a goal, by advice and by fixed turns (0: the goal was not reached)");
  app.add_option("SCENE", options.scenes, "Scenes (default courtyard room sparse)");
  app.add_option("--runs", options.runs, "Runs of each scene (default 5)");
  app.add_option("--shots", options.shots, "Shots of each patch (default 20000)");
  app.add_option("--goal", options.goal, "95 % bounds of every LiDAR (default 2mm,0.02deg)");
  CLI11_PARSE(app, argc, argv);
  return rigcal::run_trials(options);
}
