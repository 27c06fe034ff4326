#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal::speed {

/// A run of the program itself, from its start to its end, as a user sees it: the middle one, by its time, of some.
struct ProgramRun {
  std::string name;
  double wall_s = 0.0;
  double first_wall_s = 0.0;  ///< Of the first run, before memory and files are where the next ones find them.
  int runs = 0;
  double cpu_s = 0.0;                                  ///< Of all threads, user and system.
  double peak_mb = 0.0;                                ///< The most memory it held, 10^6 bytes.
  std::uint64_t points = 0;                            ///< In stops.
  double input_mb = 0.0;                               ///< Size of what it read.
  std::vector<std::pair<std::string, double>> stages;  ///< Seconds of each, from report.json.
  int found = 0;                                       ///< Sensors beside the base that have a transform,
  double worst_m = 0.0;                                ///< and the worst one's distance from the truth.

  /// Added up over the stages of which `wanted` is true.
  template <class Wanted>
  [[nodiscard]] double seconds(const Wanted& wanted) const {
    double sum = 0.0;
    for (const auto& [stage, s] : stages) sum += wanted(stage) ? s : 0.0;
    return sum;
  }
  /// Reading and all stages up to the verdict of the LiDARs.
  [[nodiscard]] double until_lidars_s() const;
  /// Images, edges and solution of the cameras; without the colours of the map.
  [[nodiscard]] double cameras_s() const;
};

struct ProgramOptions {
  std::string rig;      ///< A rig file with LiDARs and two cameras.
  std::string scratch;  ///< A folder for simulated runs, 2 GB; made and removed again.
  std::uint64_t seed = 1;
  double scale = 1.0;  ///< Of the numbers of points; below 0.1 there are no images.
  int threads = 1;
  int runs = 3;  ///< Of each program: pages that a virtual machine's host has not given before take as long as reading.
};

/// Simulates a session of 4e7 shots with images, exports its 1.7e7 points in stops as patches, and calibrates both:
/// "patches", "dump" (LiDARs alone), "dump and images". This process must be rigcal itself, and not yet large: on Linux
/// a child's peak counts from its parent's. Errors: what the program says, cancelled.
[[nodiscard]] Expected<std::vector<ProgramRun>> time_programs(const ProgramOptions& options, const RunContext& context);

}  // namespace rigcal::speed
