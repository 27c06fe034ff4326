#include "core/pipeline/range_stage.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/text.h"
#include "core/quality/lidar_quality.h"
#include "core/voxel/range_correction.h"

namespace rigcal {
namespace {

// Even odds are what data give that say nothing.
constexpr double beyond_doubt = 0.9;
// Of the sigma of a step: what is less than this is not worth another round.
constexpr double settled = 0.5;

double most_sigmas(const RangeOffsets& offsets) {
  double most = 0.0;
  for (Eigen::Index i = 0; i < offsets.step_m.size(); ++i) {
    most = std::max(most, std::abs(offsets.step_m[i]) / std::sqrt(offsets.covariance(i, i)));
  }
  return most;
}

}  // namespace

std::optional<RangeOffsets> offsets_that_stand_out(const LidarSolution& solution) {
  RangeOffsets offsets = find_range_offsets(solution.refined.map.features, solution.state, solution.layout,
                                            solution.adjust, solution.range_offset_m, usual_range_offset_m);
  if (!offsets.known) return std::nullopt;
  const bool stands_out =
      solution.range_offset_m.empty() ? offsets.likely > beyond_doubt : most_sigmas(offsets) > settled;
  if (!stands_out) return std::nullopt;
  return offsets;
}

void shorten_ranges(const LidarRecording& recording, const RangeOffsets& offsets, LidarSolution& solution) {
  if (solution.corrected.empty()) solution.corrected = recording.patches;
  solution.range_offset_m.resize(recording.lidar_sensors.size());
  for (std::size_t i = 0; i < solution.range_offset_m.size(); ++i) {
    solution.range_offset_m[i] += offsets.step_m[static_cast<Eigen::Index>(i)];
  }
  parallel_for(solution.corrected.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      shorten_ranges(solution.corrected[k], offsets.step_m[solution.corrected[k].lidar]);
    }
  });
  solution.state = solution.layout.moved(solution.state, offsets.shift * offsets.step_m);
}

void forget_offsets_of_misplaced(CalibrationResult& result, LidarSolution& solution) {
  const auto is_lost = [&](const SensorResult& s) { return s.name == result.base || s.status == Status::failed; };
  const bool is_base_alone = result.sensors.size() > 1 && std::ranges::all_of(result.sensors, is_lost);
  for (SensorResult& sensor : result.sensors) {
    if (sensor.status == Status::failed || is_base_alone) sensor.range_offset.reset();
  }
  if (!is_base_alone) return;
  solution.range_offset_m.clear();
  solution.corrected.clear();
}

std::string range_offset_words(const CalibrationResult& result) {
  std::string list;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.range_offset) continue;
    const double offset_m = sensor.range_offset->value_m;
    list += (list.empty() ? " " : ", ") + sensor.name + " by " + fixed_text(1e3 * std::abs(offset_m), 1) +
            (offset_m > 0.0 ? " mm (too long)" : " mm (too short)");
  }
  if (list.empty()) return list;
  return "ranges that are off by a constant were corrected for the calibration:" + list +
         "; clouds of other programs lie on each other only with the same correction";
}

}  // namespace rigcal
