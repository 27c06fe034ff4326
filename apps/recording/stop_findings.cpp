#include <algorithm>
#include <cstdio>

#include "apps/recording/stop_reader.h"
#include "core/base/seconds.h"
#include "core/base/text.h"
#include "core/voxel/cells.h"

// What is said about stops that were read: why they are of no use, and what a user should know of them.
namespace rigcal {
namespace {

// A rest that goes on after a bump or after creep: turned by no more than this, and not later.
constexpr double bumped_deg = 1.5;
constexpr std::int64_t bumped_ns = 4'000'000'000;
constexpr double notable_tremble_deg = 0.02;

constexpr double worthy_share = 1e-3;

// The points need half a second of a stop and more to confirm it, and see a stop of this length in any case.
constexpr double surely_seen_s = 2.0;
constexpr double most_blind_share = 0.25;

std::uint64_t dropped(const PointCounts& points, DropReason reason) {
  return points.dropped[static_cast<std::size_t>(reason)];
}

// Empty where there was none.
std::string overflow_text(const PointCounts& points) {
  const std::uint64_t overflow = dropped(points, DropReason::overflow);
  if (overflow == 0) return {};
  return std::to_string(overflow) + " points came too densely to be held until their stop was sure, and are left out";
}

// A rest of this length is a stop, however far its turn swings, unless the rig trembles in it.
bool rests_tremble(const StillFigures& gyro) { return gyro.longest_brief_rest_s > surely_seen_s; }

// Empty where there were none.
std::string brief_rests_text(const StillFigures& gyro) {
  if (gyro.brief_rests == 0) return {};
  const bool one = gyro.brief_rests == 1;
  const std::string pauses = std::to_string(gyro.brief_rests) + (one ? " pause" : " pauses") +
                             " between turns, of about " + fixed_text(gyro.longest_brief_rest_s, 1) + " s at most, " +
                             (one ? "was" : "were");
  if (!rests_tremble(gyro)) return pauses + " too short for a stop, as the swing of a turn has to fade first";
  return pauses +
         " no stop, though long enough: the rig seems to tremble (a table that hunts for its place, wind, a running "
         "engine)";
}

std::string mend_of_rests(const StillFigures& gyro) {
  if (!rests_tremble(gyro)) return "let the rig rest for two seconds and more at every stop";
  return "switch off what shakes the rig, brake the table or let its drive rest at every stop, and stand it firmly, "
         "sheltered from wind";
}

// A steady slow rotation at every stop, faster than creep that adds up, looks to a gyro as its bias does.
bool rest_is_doubtful(const StopReading& summary) {
  if (summary.source != StopSource::gyro || summary.view.points == 0 || summary.view.stops > 0) return false;
  double longest_s = 0.0;
  double sum_s = 0.0;
  for (const StopRecord& stop : summary.stops) {
    const double length_s = seconds_of_ns(stop.stop.end_ns - stop.stop.start_ns);
    longest_s = std::max(longest_s, length_s);
    sum_s += length_s;
  }
  return longest_s >= surely_seen_s && summary.view.blind_s < most_blind_share * sum_s;
}

std::vector<std::string> file_findings(const StreamSource& source, const StopReading& summary) {
  std::vector<std::string> findings;
  for (const std::string& finding : summary.notes.findings) findings.push_back(source.file + ": " + finding);
  return findings;
}

void append_stop_warnings(const StopReading& summary, std::vector<std::string>& warnings) {
  char text[300];
  if (summary.source == StopSource::gyro && summary.gyro.brief_rests > 0)
    warnings.push_back(brief_rests_text(summary.gyro) + ": " + mend_of_rests(summary.gyro));
  if (summary.source == StopSource::points && summary.gyro.imu_samples > 0) {
    warnings.emplace_back(
        "the gyro shows no rest (does the rig tremble?): the stops were found from the points, and how far the rig "
        "turned between them is searched");
  }
  if (rest_is_doubtful(summary)) {
    warnings.emplace_back(
        "the gyro finds the stops, but no LiDAR ever sees the rig at rest: does it turn slowly on, which a gyro takes "
        "for its own bias? Then the stops are smeared; let it come to rest, and brake what drives it");
  }
  if (summary.view.blind_s > 0.0 && summary.source == StopSource::points) {
    std::snprintf(text, sizeof text,
                  "for %.1f s nothing seemed to move, but no LiDAR saw surfaces enough to tell; that time is left out",
                  summary.view.blind_s);
    warnings.emplace_back(text);
  }
  double tremble_deg = 0.0;
  double farthest_deg = 0.0;
  std::string cut_rests;
  const StopRecord* before = nullptr;
  for (const StopRecord& stop : summary.stops) {
    const int index = stop.stop.index;
    if (!stop.rotation_known && summary.source == StopSource::gyro) {
      const bool vague = !(stop.rotation_sigma_rad <= StopOptions{}.most_rotation_sigma_rad);
      warnings.push_back(std::string("the inertial unit ") + (vague ? "is too vague about the way" : "was silent") +
                         " before stop " + std::to_string(index) + ": how far the rig turned there is not known");
    }
    if (stop.end == StopEnd::creep) {
      std::snprintf(text, sizeof text, "the rig slowly crept away in stop %d: it ends there, after %.1f s", index,
                    seconds_of_ns(stop.stop.end_ns - stop.stop.start_ns));
      warnings.emplace_back(text);
    }
    const double turned_deg = to_deg(log_so3(stop.R_previous_this).norm());
    const bool soon = before != nullptr && stop.stop.start_ns - before->stop.end_ns < bumped_ns;
    if (soon && stop.rotation_known && turned_deg < bumped_deg) {
      cut_rests += (cut_rests.empty() ? "" : ", ") + std::to_string(index);
      farthest_deg = std::max(farthest_deg, turned_deg);
    }
    tremble_deg = std::max(tremble_deg, to_deg(stop.tremble_rad));
    before = &stop;
  }
  if (!cut_rests.empty()) {
    std::snprintf(text, sizeof text, "%.2f deg", farthest_deg);
    warnings.push_back(
        "the rig was bumped or crept within a rest, which was cut there: each of these stops stands within " +
        std::string(text) + " of the one before it: " + cut_rests);
  }
  if (tremble_deg > notable_tremble_deg) {
    std::snprintf(text, sizeof text, "the rig trembles at rest, by up to %.3f deg (root mean square)", tremble_deg);
    warnings.emplace_back(text);
  }
}

}  // namespace

std::optional<Error> reading_error(const StreamSource& source, const StopOptions& options, const StopReading& summary) {
  if (summary.ingest.unfit) {
    Error error = *summary.ingest.unfit;
    error.where = source.path;
    return error;
  }
  if (!summary.stops.empty()) return std::nullopt;
  if (!summary.truncation.empty()) {
    return input_error("no stop is in what can be read of it: " + summary.truncation, source.path,
                       "record anew, or copy it anew; rigcal inspect tells what it holds up to there");
  }
  char text[300];
  if (summary.source == StopSource::points && summary.view.blind_s > 0.0) {
    std::snprintf(
        text, sizeof text,
        "no inertial readings, and the points do not tell whether the rig turns: for %.1f s nothing seemed to "
        "move, but no LiDAR saw surfaces enough that face different ways",
        summary.view.blind_s);
    return input_error(
        text, source.path,
        "switch the inertial unit of the AVIA on (imu: true in the rig file), or record nearer to walls");
  }
  if (summary.source == StopSource::points) {
    std::snprintf(text, sizeof text,
                  "the rig never stands still, as far as the points show: its longest rest has %.2f s, %.2f s are "
                  "needed",
                  summary.view.longest_still_s, options.min_stop_s);
  } else {
    std::snprintf(text, sizeof text,
                  "the rig never stands still: its longest rest has %.2f s, %.2f s are needed (noise of the gyro: "
                  "%.3f deg/s)",
                  summary.gyro.longest_still_s, options.min_stop_s, to_deg(summary.gyro.gyro_noise_rad_s));
  }
  const std::string pauses = brief_rests_text(summary.gyro);
  return input_error(text + (pauses.empty() ? pauses : "; " + pauses), source.path, mend_of_rests(summary.gyro));
}

Error no_points_error(const StreamSource& source, const StopReading& summary, std::uint64_t too_far) {
  const std::string overflow = overflow_text(summary.points);
  if (too_far > 0) {
    return input_error("all points in the range of their LiDAR while the rig stood still lie farther than " +
                           fixed_text(CellOptions{}.max_range_m, 0) + " m, where none are used" +
                           (overflow.empty() ? overflow : "; " + overflow),
                       source.path, "let the LiDARs see nearer surfaces, or check that what they see is in metres");
  }
  if (!overflow.empty())
    return input_error("no points while the rig stood still: " + overflow, source.path,
                       "give it fewer points a second: a part of the LiDARs at a time, or thinner clouds");
  return input_error("no points while the rig stood still", source.path, "check that sampling was on");
}

void warn_of_file(const StreamSource& source, const StopReading& summary, Reporter& reporter) {
  for (const std::string& finding : file_findings(source, summary)) reporter.warn(finding);
}

std::vector<std::string> reading_warnings(const StreamSource& source, const StopReading& summary) {
  std::vector<std::string> warnings = summary.ingest.warnings;
  if (!summary.truncation.empty()) warnings.push_back(source.file + ": " + summary.truncation);
  for (std::string& finding : file_findings(source, summary)) warnings.push_back(std::move(finding));
  if (!source.complete) {
    warnings.push_back(source.path + ": the recording was cut short; what is there is used");
  }
  if (summary.gyro.bias_changes > 0) {
    warnings.emplace_back("what was first taken for rest was a slow steady rotation: the first stops are doubtful");
  }
  if (summary.gyro.imu_unusable > 0) {
    warnings.push_back(std::to_string(summary.gyro.imu_unusable) +
                       " readings of the inertial unit were left out: they came too late, or no unit can read such "
                       "values; is the recording damaged?");
  }
  if (const std::string text = overflow_text(summary.points); !text.empty()) warnings.push_back(text);
  const std::uint64_t late = dropped(summary.points, DropReason::late);
  if (static_cast<double>(late) > worthy_share * static_cast<double>(summary.points.in_stops + late)) {
    warnings.push_back(std::to_string(late) +
                       " points came when their stop was long over, and are left out; are the clocks of the LiDARs far "
                       "apart?");
  }
  append_stop_warnings(summary, warnings);
  return warnings;
}

}  // namespace rigcal
