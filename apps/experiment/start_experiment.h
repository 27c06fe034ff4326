#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

/// What the calibrations of one row start from, and how the rig is carried.
struct StartCase {
  std::string name;
  /// How far each stop stands off the turn about one axis, root mean square: 0, a turntable; else a vehicle that turns
  /// in place.
  double wander_m = 0.0;
  double wander_deg = 0.0;
  bool drives = false;  ///< A figure of eight, in 24 to 36 stops.
  bool with_gyro = true;
  double guess_m = -1.0;  ///< Each guess is off by exactly this; negative: there is none.
  double guess_deg = 0.0;
  bool shares_surfaces = true;                          ///< See sim::RandomMounting.
  bool knows_axis = false;                              ///< The rig file has the table's axis, 1.5 degrees off.
  std::optional<std::array<double, 2>> step_range_deg;  ///< Unequal steps, in 8 to 16 stops.
};

/// What became of the rigs of one row. A rig is right where every LiDAR is within 5 mm and 0.05 degrees, flagged where
/// each that is not is `weak` or `failed`, else wrong.
struct StartRow {
  StartCase kind;
  int rigs = 0;
  int right = 0;
  int flagged = 0;
  int wrong = 0;
  int lidars = 0;  ///< Without the bases.
  int lidars_right = 0;
  int right_but_flagged = 0;  ///< LiDARs that are right and not `good`.
  double median_mm = 0.0;     ///< Of the LiDARs that are right.
  double worst_mm = 0.0;
  double median_deg = 0.0;
  double worst_deg = 0.0;
  double start_median_s = 0.0;  ///< The stage `start`.
  double start_worst_s = 0.0;
  std::vector<std::string> misses;  ///< A line for each rig that is not right.
};

struct StartExperimentOptions {
  int rigs = 20;
  std::uint64_t seed = 1;
  int points = 20000;              ///< Of a patch.
  std::vector<std::string> cases;  ///< Names; empty: all.
  /// Also tries ever worse guesses, from those of the case `guess` on, until fewer than 99 of 100 rigs are right.
  bool basin = false;
};

/// The names that `StartExperimentOptions::cases` may have.
[[nodiscard]] std::vector<std::string> start_case_names();

/// Calibrates random rigs in the three scenes with 12 to 24 stops, in memory. Errors: cancelled.
[[nodiscard]] Expected<std::vector<StartRow>> try_starts(const StartExperimentOptions& options,
                                                         const RunContext& context);

[[nodiscard]] std::string start_experiment_text(const std::vector<StartRow>& rows);
[[nodiscard]] std::string start_experiment_json(const std::vector<StartRow>& rows);

}  // namespace rigcal
