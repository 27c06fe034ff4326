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

// In the mean of what a LiDAR sees, and on black against white.
double most_sigmas(const RangeErrors& errors, RangeLaw law) {
  const RangeFit& fit = errors.fit(law);
  const Eigen::Index lidars = fit.step_m.size() / 2;
  double most = 0.0;
  for (int i = 0; i < lidars; ++i) {
    const double darkness = errors.darkness[static_cast<std::size_t>(i)];
    const RangeError step = fit.step_of(i);
    most = std::max(most, std::abs(step.at(darkness)) / std::sqrt(fit.variance_at(i, darkness)));
    const double of_black = fit.covariance(lidars + i, lidars + i);
    if (of_black > 0.0) most = std::max(most, std::abs(step.black_m) / std::sqrt(of_black));
  }
  return most;
}

// The likeliest one that allows for what was taken out, where that alone is no longer likely.
RangeLaw law_beyond_doubt(const RangeErrors& errors, RangeLaw taken_out) {
  if (errors.fit(taken_out).likely > (1.0 - beyond_doubt) * errors.likely_covering(taken_out)) return taken_out;
  RangeLaw best = taken_out;
  for (const RangeLaw law : all_range_laws) {
    if (covers(law, taken_out) && errors.fit(law).likely > errors.fit(best).likely) best = law;
  }
  return best;
}

RangeErrors errors_of(const LidarSolution& solution) {
  return find_range_errors(solution.refined.map.features, solution.state, solution.layout, solution.adjust,
                           solution.ranges.errors, usual_range_errors);
}

std::string error_words(double error_m) {
  const std::string words = fixed_text(1e3 * std::abs(error_m), 1) + " mm";
  if (words == "0.0 mm") return words;
  return words + (error_m > 0.0 ? " (too long)" : " (too short)");
}

}  // namespace

std::optional<RangeFinding> errors_that_stand_out(const LidarSolution& solution) {
  RangeFinding finding;
  finding.errors = errors_of(solution);
  if (!finding.errors.known) return std::nullopt;
  finding.law = law_beyond_doubt(finding.errors, solution.ranges.law);
  if (finding.law == solution.ranges.law &&
      (finding.law == RangeLaw::none || most_sigmas(finding.errors, finding.law) <= settled)) {
    return std::nullopt;
  }
  return finding;
}

bool correction_is_refuted(const LidarSolution& solution) {
  const RangeErrors errors = errors_of(solution);
  return errors.known && errors.fit(RangeLaw::none).likely > beyond_doubt;
}

void shorten_ranges(const LidarRecording& recording, const RangeFinding& finding, LidarSolution& solution) {
  const RangeFit& fit = finding.errors.fit(finding.law);
  if (solution.corrected.empty()) solution.corrected = recording.patches;
  solution.ranges.law = finding.law;
  solution.ranges.errors.resize(recording.lidar_sensors.size());
  for (std::size_t i = 0; i < solution.ranges.errors.size(); ++i) {
    solution.ranges.errors[i] += fit.step_of(static_cast<int>(i));
  }
  parallel_for(solution.corrected.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      shorten_ranges(solution.corrected[k], fit.step_of(solution.corrected[k].lidar));
    }
  });
  solution.state = solution.layout.moved(solution.state, finding.errors.shift * fit.step_m);
}

void forget_ranges_of_misplaced(CalibrationResult& result, LidarSolution& solution) {
  const auto is_lost = [&](const SensorResult& s) { return s.name == result.base || s.status == Status::failed; };
  const bool is_base_alone = result.sensors.size() > 1 && std::ranges::all_of(result.sensors, is_lost);
  for (SensorResult& sensor : result.sensors) {
    if (sensor.status != Status::failed && !is_base_alone) continue;
    sensor.range_offset.reset();
    sensor.dark_offset.reset();
  }
  if (!is_base_alone) return;
  solution.ranges = {};
  solution.corrected.clear();
}

std::string range_words(const CalibrationResult& result) {
  std::string list;
  bool has_dark = false;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.range_offset) continue;
    list += (list.empty() ? " " : ", ") + sensor.name + " by " + error_words(sensor.range_offset->value_m);
    if (!sensor.dark_offset) continue;
    has_dark = true;
    list += " on white and " + error_words(sensor.range_offset->value_m + sensor.dark_offset->value_m) + " on black";
  }
  if (list.empty()) return list;
  return std::string("ranges that are off by ") + (has_dark ? "what goes with reflectivity" : "a constant") +
         " were corrected for the calibration:" + list +
         "; clouds of other programs lie on each other only with the same correction";
}

}  // namespace rigcal
