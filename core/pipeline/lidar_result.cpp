#include "core/pipeline/lidar_result.h"

#include <algorithm>
#include <set>

#include "core/pipeline/place_findings.h"
#include "core/pipeline/surface_trust.h"
#include "core/pipeline/used_shares.h"
#include "core/quality/open_directions.h"
#include "core/quality/verdict.h"
#include "core/start/stop_poses.h"

namespace rigcal {
namespace {

bool has_points(const LidarRecording& recording, int lidar) {
  return std::any_of(recording.patches.begin(), recording.patches.end(),
                     [&](const PatchCells& p) { return p.lidar == lidar && !p.cells.empty(); });
}

// In which what it saw took part.
std::size_t stops_of(int lidar, const LidarRecording& recording, const LidarSolution& s) {
  std::set<int> stops;
  for (std::size_t k = 0; k < recording.patches.size(); ++k) {
    if (s.use[k] && recording.patches[k].lidar == lidar) stops.insert(recording.patches[k].stop);
  }
  return stops.size();
}

struct Findings {
  const SolutionQuality& quality;
  std::vector<UsedShare> used;
  std::vector<PlaceFindings> places;
};

void set_place_findings(const PlaceFindings& places, const Rig& rig, const LidarRecording& recording,
                        LidarEvidence& e) {
  const auto name_of = [&](int lidar) {
    return rig.sensors[static_cast<std::size_t>(recording.lidar_sensors[static_cast<std::size_t>(lidar)])].name;
  };
  if (places.stands_at) e.stands_at = name_of(*places.stands_at);
  if (places.same_place_as) e.same_place_as = name_of(*places.same_place_as);
  e.guess_is_inverse = places.guess_is_inverse;
  e.from_guess_rad = places.from_guess_rad;
  e.from_guess_m = places.from_guess_m;
}

// With the stop's number that users see.
TimeHalves halves_of(int lidar, const LidarRecording& recording, const SolutionQuality& quality) {
  if (static_cast<std::size_t>(lidar) >= quality.time_halves.size()) return {};
  TimeHalves halves = quality.time_halves[static_cast<std::size_t>(lidar)];
  if (halves.compared)
    halves.first_later_stop = recording.stops[static_cast<std::size_t>(halves.first_later_stop)].index;
  return halves;
}

HalfShares with_stop_number(HalfShares halves, const LidarRecording& recording) {
  halves.first_later_stop = recording.stops[static_cast<std::size_t>(halves.first_later_stop)].index;
  return halves;
}

// The numbers of the stops that a LiDAR has a cloud of, in their order.
std::vector<int> numbers_of(int lidar, const LidarRecording& recording) {
  std::set<int> numbers;
  for (const PatchCells& p : recording.patches) {
    if (p.lidar == lidar) numbers.insert(recording.stops[static_cast<std::size_t>(p.stop)].index);
  }
  return {numbers.begin(), numbers.end()};
}

// Clouds that were counted from another number on than the base's. Stops of a stream have times, and are the same for
// all.
void set_shifted_stops(int lidar, int base, const LidarRecording& recording, LidarEvidence& e) {
  constexpr std::size_t least_stops = 3;
  const auto has_time = [](const Stop& stop) { return stop.start_ns != 0 || stop.end_ns != 0; };
  if (std::any_of(recording.stops.begin(), recording.stops.end(), has_time)) return;
  const std::vector<int> own = numbers_of(lidar, recording);
  const std::vector<int> of_base = numbers_of(base, recording);
  if (own.size() < least_stops || own.size() != of_base.size() || own.front() == of_base.front()) return;
  const int by = own.front() - of_base.front();
  if (!std::equal(own.begin(), own.end(), of_base.begin(), [by](int a, int b) { return a == b + by; })) return;
  e.shifted_stops = StopSpan{own.front(), own.back()};
  e.base_stops = {of_base.front(), of_base.back()};
}

SensorResult judge_one(const Sensor& sensor, const Rig& rig, int lidar, int base, const LidarRecording& recording,
                       const std::optional<SE3>& guess, const LidarCalibrationOptions& options, const LidarSolution& s,
                       const Findings& findings) {
  const auto i = static_cast<std::size_t>(lidar);
  LidarEvidence e;
  e.name = sensor.name;
  e.base_name = rig.base_sensor().name;
  e.has_points = has_points(recording, lidar);
  e.saw_too_far = recording.saw_too_far(static_cast<std::size_t>(lidar));
  const std::size_t places = stops_of(lidar, recording, s);
  e.took_part = places > 0;
  e.stops = static_cast<int>(
      std::count_if(s.start.stop_known.begin(), s.start.stop_known.end(), [](char known) { return known != 0; }));
  const StopStep step = usual_step(s.state.T_G_base, s.start.stop_known);
  e.step_rad = step.turn_rad;
  e.step_m = step.move_m;
  e.base_has_points = recording.trajectory_is_prior || stops_of(base, recording, s) > 0;
  set_shifted_stops(lidar, base, recording, e);
  e.has_guess = guess.has_value();
  e.found = s.start.lidar_known[i] != 0;
  e.has_assumed_steps = s.start.has_assumed_steps;
  // One that slides does not speak against the others.
  ExtrinsicMove last = i < s.refined.last_moves.size() ? s.refined.last_moves[i] : ExtrinsicMove{};
  // What ended early as it was told is no end; `mark_unfinished` says so.
  e.converged = options.last_stage != LastStage::joint || s.refined.converged || is_rest(last, options.require);
  e.settled_late = e.converged && i < s.moves_on_one_grid.size() && !is_rest(s.moves_on_one_grid[i], options.require);
  if (e.settled_late) last = s.moves_on_one_grid[i];
  e.last_move_m = last.translation_m;
  e.last_move_rad = last.rotation_rad;
  e.match_score = s.start.matches[i].score;
  e.runner_up_score = s.start.matches[i].runner_up_score;
  const UsedShare& base_share = findings.used[static_cast<std::size_t>(base)];
  set_place_findings(findings.places[i], rig, recording, e);
  e.used_share = base_share.all > 0.0 ? findings.used[i].all / base_share.all : 1.0;
  const LidarCovariances& covariances = findings.quality.covariances;
  e.observable = i < covariances.observable.size() && covariances.observable[i] != 0;
  if (e.observable && e.took_part) {
    e.covariance = with_unevenness(covariances.with_priors[i], s.unevenness_m, places);
    e.covariance_data_only = with_unevenness(covariances.data_only[i], s.unevenness_m, places);
    e.scatter = covariances.scatter[i];
    if (i < s.frozen.size()) e.frozen = s.frozen[i];
    if (translation_bound(e.covariance) > options.require.translation_m) {
      e.helpful_turn =
          turn_for_weak_translation({s.refined.map.features, s.state, s.layout, s.adjust}, lidar, e.covariance);
    }
  }
  e.T_base_sensor = s.state.T_base_sensor[i];
  const HoldOut& held_out = findings.quality.held_out;
  e.is_checked = held_out.normalised[i] > 0.0;
  e.hold_out = held_out.normalised[i];
  e.hold_out_rms_m = held_out.rms_m[i];
  e.hold_out_start_rms_m = held_out.start_rms_m[i];
  e.halves = halves_of(lidar, recording, findings.quality);
  e.base_halves = halves_of(base, recording, findings.quality);
  e.used_halves = with_stop_number(findings.used[i].halves, recording);
  e.base_used_halves = with_stop_number(base_share.halves, recording);
  const Verdict verdict = judge_lidar(e, options.require);
  SensorResult result{sensor.name, verdict.status, verdict.reasons, std::nullopt, Matrix6d::Zero()};
  result.guess_T_base_sensor = guess;
  result.hold_out = {e.hold_out, e.hold_out_rms_m, e.hold_out_start_rms_m, "m"};
  if (e.observable && e.found && e.took_part) {
    result.weak_directions = weak_directions(e.covariance, e.T_base_sensor, options.require, e.frozen);
  }
  if (verdict.status != Status::failed) {
    result.T_base_sensor = e.T_base_sensor;
    result.covariance = e.covariance;
  }
  return result;
}

// A LiDAR of the rig that the recording knows nothing of, or a base that took no part.
SensorResult judge_absent(const std::string& name, const std::string& base, const LidarRecording& recording, int lidar,
                          const Requirement& require) {
  LidarEvidence nothing;
  nothing.name = name;
  nothing.base_name = base;
  nothing.has_points = has_points(recording, lidar);
  nothing.saw_too_far = recording.saw_too_far(static_cast<std::size_t>(lidar));
  nothing.took_part = false;
  Verdict verdict = judge_lidar(nothing, require);
  return {name, verdict.status, std::move(verdict.reasons), {}, {}};
}

// What an early end did not solve must not look solved.
void mark_unfinished(LastStage last, SensorResult& sensor) {
  if (last == LastStage::poses) {
    sensor = {sensor.name,
              Status::failed,
              {"not solved: the run ended before the extrinsics, as it was told; leave --stages out"},
              {},
              {}};
  } else if (last == LastStage::extrinsics && sensor.status != Status::failed) {
    sensor.status = Status::weak;
    sensor.reasons.emplace_back(
        "the run ended before poses and extrinsics were adjusted together, as it was told: its sigma takes the poses "
        "for exact; leave --stages out");
  }
}

}  // namespace

bool is_rest(const ExtrinsicMove& move, const Requirement& require) {
  return move.translation_m <= 0.1 * require.translation_m && move.rotation_rad <= 0.1 * require.rotation_rad;
}

SolutionQuality weigh_solution(int base_lidar, const std::vector<std::optional<SE3>>& guess, const LidarSolution& s) {
  const SolvedPlanes solved{s.refined.map.features, s.state, s.layout, s.adjust, usual_range_errors, s.ranges};
  // Seen from the base, which the guess says of: the LiDAR whose frame all was solved in has none in its own.
  const auto base = static_cast<std::size_t>(base_lidar);
  const std::vector<SE3>& found = s.start.state.T_base_sensor;
  std::vector<SE3> start_extrinsics(guess.size());
  for (std::size_t i = 0; i < guess.size(); ++i) {
    const bool is_guessed = guess[i] && guess[base];
    const SE3 T_base_this = is_guessed ? guess[base]->inverse() * *guess[i] : found[base].inverse() * found[i];
    start_extrinsics[i] = s.state.T_base_sensor[base] * T_base_this;
  }
  return {lidar_covariances(solved, base_lidar), hold_out(solved, base_lidar, start_extrinsics),
          compare_time_halves(solved)};
}

CalibrationResult judge_solution(const Rig& rig, const LidarRecording& recording, int base_lidar,
                                 const std::vector<std::optional<SE3>>& guess, const LidarCalibrationOptions& options,
                                 const LidarSolution& s, const SolutionQuality& quality) {
  const auto judged_guess = options.judges_guesses ? guess : std::vector<std::optional<SE3>>(guess.size());
  const Findings findings{quality, used_shares(recording, s), place_findings(judged_guess, s, base_lidar)};
  CalibrationResult result;
  result.base = rig.base_sensor().name;
  result.method = "targetless";
  result.status = Status::good;
  for (std::size_t k = 0; k < rig.sensors.size(); ++k) {
    const Sensor& sensor = rig.sensors[k];
    if (!sensor.is_lidar()) continue;
    const auto at = std::find(recording.lidar_sensors.begin(), recording.lidar_sensors.end(), static_cast<int>(k));
    const int lidar = static_cast<int>(at - recording.lidar_sensors.begin());
    SensorResult one;
    const bool is_blind_base = lidar == base_lidar && stops_of(lidar, recording, s) == 0;
    if (at == recording.lidar_sensors.end() || is_blind_base) {
      one = judge_absent(sensor.name, result.base, recording, lidar, options.require);
    } else if (lidar == base_lidar) {
      one = {sensor.name, Status::good, {}, SE3{}, Matrix6d::Zero()};
      one.guess_T_base_sensor = SE3{};
    } else {
      one = judge_one(sensor, rig, lidar, base_lidar, recording, guess[static_cast<std::size_t>(lidar)], options, s,
                      findings);
      mark_unfinished(options.last_stage, one);
    }
    const auto i = static_cast<std::size_t>(lidar);
    if (one.T_base_sensor && i < s.noise.size()) one.noise = s.noise[i];
    if (one.T_base_sensor && lidar != base_lidar && i < s.grid_shifts.size()) one.grid_shift = s.grid_shifts[i];
    const std::vector<RangeError>& range_sigma_m = quality.covariances.range_sigma_m;
    if (i < s.ranges.errors.size() && i < range_sigma_m.size()) {
      one.range_offset = RangeOffset{s.ranges.errors[i].white_m, range_sigma_m[i].white_m};
      if (covers(s.ranges.law, RangeLaw::by_darkness)) {
        one.dark_offset = RangeOffset{s.ranges.errors[i].black_m, range_sigma_m[i].black_m};
      }
    }
    result.status = std::max(result.status, one.status);
    result.sensors.push_back(std::move(one));
  }
  for (std::size_t j = 0; j < recording.stops.size(); ++j) {
    result.trajectory.push_back({recording.stops[j], s.state.T_G_base[j], s.start.stop_known[j] != 0});
  }
  for (const PatchCells& patch : recording.patches) {
    const int sensor = recording.lidar_sensors[static_cast<std::size_t>(patch.lidar)];
    StopPose& stop = result.trajectory[static_cast<std::size_t>(patch.stop)];
    stop.points[rig.sensors[static_cast<std::size_t>(sensor)].name] += patch.points;
  }
  return result;
}

}  // namespace rigcal
