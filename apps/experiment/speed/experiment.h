#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/experiment/speed/bandwidth.h"
#include "apps/experiment/speed/growth.h"
#include "apps/experiment/speed/program_runs.h"
#include "apps/experiment/speed/stage_table.h"

namespace rigcal::speed {

/// A calibration of many scans by one LiDAR, as large as one that another program was measured with.
struct ManyScans {
  StageTable table;
  double map_s = 0.0;  ///< Points to planes: cells and map.
  double map_cpu_s = 0.0;
  double iteration_s = 0.0;  ///< Factors, solution and the cost of the step.
  double iteration_cpu_s = 0.0;
};

/// How fast a calibration is on this machine; parts that were not asked for are empty.
struct Experiment {
  int threads = 0;
  Bandwidth bandwidth;
  std::vector<ProgramRun> programs;
  std::vector<StageTable> tables;
  std::optional<ManyScans> scans;
  std::vector<GrowthRow> growth;
};

/// What was aimed at, and what published programs take for as much.
struct Goal {
  std::string what;
  double measured = 0.0;
  double goal = 0.0;
  double known = 0.0;  ///< 0: nothing is known.
  std::string unit;
};

struct ExperimentOptions {
  std::vector<std::string> parts;  ///< Names; empty: all.
  double scale = 1.0;              ///< Of all numbers of points.
  std::uint64_t seed = 1;
  ProgramOptions programs;  ///< Its scale is taken from above,
  GrowthOptions growth;     ///< and so are this one's scale and seed.
};

/// "programs", "stages", "scans", "growth".
[[nodiscard]] std::vector<std::string> part_names();

/// Errors: cancelled; what the program says that is run.
[[nodiscard]] Expected<Experiment> run_parts(const ExperimentOptions& options, const RunContext& context);

/// Of the parts that were measured. With a scale below one they are met easily, and mean nothing.
[[nodiscard]] std::vector<Goal> goals_of(const Experiment& experiment);

[[nodiscard]] std::string experiment_text(const Experiment& experiment);
/// See docs/schema/experiment_speed.json.
[[nodiscard]] std::string experiment_json(const Experiment& experiment);
/// Names and contents of what is written into a folder beside the two above: tables as CSV, pictures.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> experiment_files(const Experiment& experiment);
/// All names that there may be.
[[nodiscard]] std::vector<std::string> experiment_file_names();

}  // namespace rigcal::speed
