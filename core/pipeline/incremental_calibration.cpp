#include "core/pipeline/incremental_calibration.h"

#include <algorithm>
#include <utility>

#include "core/base/keeping_reporter.h"
#include "core/base/parallel.h"
#include "core/base/seconds.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/pipeline/stop_placement.h"
#include "core/start/noise_estimate.h"

namespace rigcal {
namespace {

// Up to so many stops a search from scratch costs little, and an early mistake does not stay.
constexpr int few_stops = 3;
// Everything is searched for again when there are so many times as many stops, and sooner while something failed.
constexpr double growth = 2.0;
constexpr double growth_after_failure = 1.5;

int base_lidar(const Rig& rig, const std::vector<int>& lidar_sensors) {
  const auto base = std::find(lidar_sensors.begin(), lidar_sensors.end(), rig.base);
  return static_cast<int>(base - lidar_sensors.begin());
}

}  // namespace

IncrementalCalibration::IncrementalCalibration(Rig rig, std::vector<int> lidar_sensors,
                                               std::vector<std::optional<SE3>> guess_T_base_lidar,
                                               const IncrementalOptions& options)
    : rig_(std::move(rig)), guess_(std::move(guess_T_base_lidar)), options_(options) {
  recording_.lidar_sensors = std::move(lidar_sensors);
}

void IncrementalCalibration::add_stop(CalibrationStop stop) {
  const std::size_t before = recording_.patches.size();
  append(std::move(stop), recording_);
  const std::size_t count = recording_.patches.size();
  recording_.surfels.resize(count);
  const bool has_camera =
      std::any_of(rig_.sensors.begin(), rig_.sensors.end(), [](const Sensor& sensor) { return !sensor.is_lidar(); });
  if (has_camera) recording_.outlines.resize(count);
  const std::vector<BeamWidth> beams = beam_widths(rig_, recording_.lidar_sensors);
  parallel_for(count - before, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = before + begin; k < before + end; ++k) {
      recording_.surfels[k] = extract_surfels(recording_.patches[k], SurfelOptions{});
      if (has_camera) recording_.outlines[k] = find_patch_outlines(recording_.patches[k], beams);
    }
  });
}

bool IncrementalCalibration::is_due_anew() const {
  const auto stops = static_cast<int>(recording_.stops.size());
  const bool has_failed = std::find(failed_at_search_.begin(), failed_at_search_.end(), 1) != failed_at_search_.end();
  const double least = stops_at_search_ * (has_failed ? growth_after_failure : growth);
  if (!solution_ || stops <= few_stops || stops >= least) return true;
  for (const PatchSurfels& patch : recording_.surfels) {
    if (!solution_->start.lidar_known[static_cast<std::size_t>(patch.lidar)] && !patch.surfels.empty()) return true;
  }
  return false;
}

std::optional<Matrix3d> IncrementalCalibration::turn_between(std::size_t from, std::size_t to,
                                                             const Start& start) const {
  Matrix3d R = Matrix3d::Identity();
  for (std::size_t j = from + 1; j <= to; ++j) {
    std::optional<Matrix3d> turn = recording_.R_previous_this[j];
    const std::optional<GyroTurn>& told = recording_.gyro_turns[j];
    // Where nobody had a guess of where the gyro sits, its LiDAR has been found by now.
    if (!turn && told && start.lidar_known[static_cast<std::size_t>(told->lidar)]) {
      const Matrix3d& R_base_gyro = start.state.T_base_sensor[static_cast<std::size_t>(told->lidar)].R;
      turn = R_base_gyro * told->R_previous_this * R_base_gyro.transpose();
    }
    if (!turn) return std::nullopt;
    R = nearest_rotation(R * *turn);
  }
  return R;
}

std::optional<SE3> IncrementalCalibration::pose_of(std::size_t stop, const Start& start) const {
  std::size_t from = stop;
  while (from > 0 && start.stop_known[from - 1] == 0) --from;
  if (from == 0) return std::nullopt;
  --from;
  if (!recording_.trajectory.empty()) {
    return start.state.T_G_base[from] * start.given_T_G_base[from].inverse() * start.given_T_G_base[stop];
  }
  const PlacementInput input{start, recording_.surfels, static_cast<int>(stop), static_cast<int>(from)};
  if (const auto R = turn_between(from, stop, start)) return place_stop(input, *R);
  const bool has_axis = rig_.turntable && rig_.turntable->axis;
  return has_axis ? find_stop(input) : std::nullopt;
}

std::optional<WarmStart> IncrementalCalibration::warm_start() const {
  if (is_due_anew()) return std::nullopt;
  WarmStart warm{solution_->start, {}, solution_->T_grid_G, solution_->gyro_lidar};
  Start& start = warm.start;
  start.state = solution_->state;
  const std::size_t before = start.stop_known.size();
  warm.stops_before = static_cast<int>(before);
  for (std::size_t j = before; j < recording_.stops.size(); ++j) {
    start.state.T_G_base.push_back(start.state.T_G_base.back());
    start.stop_known.push_back(0);
    if (!recording_.trajectory.empty()) {
      start.given_T_G_base.push_back(start.given_T_G_base.front() * recording_.trajectory.front()->inverse() *
                                     *recording_.trajectory[j]);
    }
    // No search would find one that saw nothing.
    const bool is_blind =
        recording_.trajectory.empty() && !saw_anything({start, recording_.surfels, static_cast<int>(j), 0});
    if (is_blind) continue;
    const std::optional<SE3> T = pose_of(j, start);
    if (!T) return std::nullopt;
    start.state.T_G_base.back() = *T;
    start.stop_known.back() = 1;
  }
  // Those that were left out last may lie on what was seen since. Whoever was left out again has to wait for the
  // search.
  std::size_t left_out = before;
  while (left_out > 0 && start.stop_known[left_out - 1] == 0) --left_out;
  for (std::size_t j = left_out; j < before; ++j) {
    const std::optional<SE3> T = pose_of(j, start);
    if (!T) continue;
    start.state.T_G_base[j] = *T;
    start.stop_known[j] = 1;
  }
  for (std::size_t i = 0; i < recording_.lidar_sensors.size(); ++i) {
    warm.noise.push_back(estimate_noise(recording_.surfels, static_cast<int>(i), NoiseModel{}));
  }
  return warm;
}

Expected<StopEstimate> IncrementalCalibration::estimate(const RunContext& context) {
  const auto begun = SteadyClock::now();
  LidarCalibrationOptions options = options_.lidars;
  options.require = options_.goal;
  const std::optional<WarmStart> warm = warm_start();
  KeepingReporter reporter(context.reporter);
  const auto solve = [&](const WarmStart* from) -> Expected<CalibrationResult> {
    std::unique_ptr<LidarSolution> solution;
    auto solved = estimate_lidars(rig_, recording_, guess_, options, {reporter, context.stop}, from, solution);
    if (solved) solution_ = std::move(solution);
    return solved;
  };
  Expected<CalibrationResult> result = solve(warm ? &*warm : nullptr);
  if (!result) return result.error();
  // What comes right though the search had failed may have come to rest on something else.
  const bool is_sudden = warm && has_sudden(result->sensors);
  if (is_sudden) {
    (void)reporter.take();
    result = solve(nullptr);
    if (!result) return result.error();
  }
  const bool searched = !warm || is_sudden;
  if (searched) {
    stops_at_search_ = static_cast<int>(recording_.stops.size());
    failed_at_search_.clear();
    for (const SensorResult& sensor : result->sensors) failed_at_search_.push_back(!sensor.T_base_sensor);
  }
  StopEstimate out;
  out.stops = static_cast<int>(recording_.stops.size());
  out.searched = searched;
  out.warnings = reporter.take();
  out.reached = result->status == Status::good;
  for (const SensorResult& sensor : result->sensors) out.lidars.push_back(one_lidar(sensor));
  if (options_.advise) advise(*result, out);
  out.wall_s = seconds_since(begun);
  return out;
}

bool IncrementalCalibration::has_sudden(const std::vector<SensorResult>& sensors) const {
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (sensors[i].T_base_sensor && failed_at_search_[i]) return true;
  }
  return false;
}

LidarEstimate IncrementalCalibration::one_lidar(const SensorResult& sensor) const {
  LidarEstimate out{sensor};
  if (!sensor.T_base_sensor || sensor.covariance.isZero(0.0)) return out;
  out.translation_bound_m = translation_bound(sensor.covariance);
  out.rotation_bound_rad = rotation_bound(sensor.covariance);
  const Matrix3d& R = sensor.T_base_sensor->R;
  out.weak_rotation = R * symmetric_eigen(sensor.covariance.topLeftCorner<3, 3>()).vectors.col(2);
  out.weak_translation = R * symmetric_eigen(sensor.covariance.bottomRightCorner<3, 3>()).vectors.col(2);
  return out;
}

void IncrementalCalibration::advise(const CalibrationResult& result, StopEstimate& out) const {
  const LidarSolution& solved = *solution_;
  std::vector<SeenSurface> surfaces;
  for (const PatchSurfels& patch : recording_.surfels) {
    for (const Surfel& s : patch.surfels) {
      surfaces.push_back({patch.lidar, patch.stop, s.mean, s.normal, s.variance / s.N});
    }
  }
  std::vector<Matrix6d> covariances(recording_.lidar_sensors.size(), Matrix6d::Zero());
  std::vector<std::string> names;
  for (std::size_t i = 0; i < covariances.size(); ++i) {
    names.push_back(rig_.sensors[static_cast<std::size_t>(recording_.lidar_sensors[i])].name);
    for (const SensorResult& sensor : result.sensors) {
      if (sensor.name == names.back()) covariances[i] = sensor.covariance;
    }
  }
  const Vector3d about = rig_.turntable && rig_.turntable->axis ? *rig_.turntable->axis : Vector3d(Vector3d::UnitZ());
  const TurningAxis axis = find_turning_axis(solved.state.T_G_base, solved.start.stop_known, about)
                               .value_or(TurningAxis{about.normalized(), Vector3d::Zero()});
  // What was not found yet stands about at its guess: enough to tell where it looks.
  std::vector<char> placed = solved.start.lidar_known;
  for (std::size_t i = 0; i < placed.size(); ++i) placed[i] = placed[i] || guess_[i];
  out.advice = advise_stop({solved.state, solved.start.stop_known, placed, base_lidar(rig_, recording_.lidar_sensors),
                            surfaces, covariances, options_.goal, axis});
  if (out.advice) out.advice_text = advice_text(*out.advice, names);
}

Expected<CalibrationResult> IncrementalCalibration::finish(
    const std::vector<CameraRecording>& cameras, const std::optional<CameraCalibrationOptions>& camera_options,
    const RunContext& context) const {
  return calibrate_rig(rig_, recording_, cameras, guess_, {options_.lidars, camera_options}, context);
}

void append(CalibrationStop stop, LidarRecording& recording) {
  const auto index = static_cast<int>(recording.stops.size());
  recording.stops.push_back(stop.stop);
  recording.R_previous_this.push_back(stop.R_previous_this);
  recording.gyro_turns.push_back(stop.gyro_turn);
  recording.turned_rad.push_back(stop.turned_rad);
  // A trajectory has a pose for every stop or is none.
  if (stop.T_G_base) recording.trajectory.push_back(stop.T_G_base);
  recording.trajectory_is_prior = !recording.trajectory.empty();
  recording.too_far.push_back(std::move(stop.too_far));
  for (PatchCells& patch : stop.patches) {
    patch.stop = index;
    recording.patches.push_back(std::move(patch));
  }
}

std::vector<CalibrationStop> stops_of(const LidarRecording& recording) {
  std::vector<CalibrationStop> out;
  for (std::size_t j = 0; j < recording.stops.size(); ++j) {
    CalibrationStop& stop = out.emplace_back(CalibrationStop{recording.stops[j], {}, {}, {}, {}, {}, {}});
    if (j < recording.R_previous_this.size()) stop.R_previous_this = recording.R_previous_this[j];
    if (j < recording.gyro_turns.size()) stop.gyro_turn = recording.gyro_turns[j];
    if (j < recording.turned_rad.size()) stop.turned_rad = recording.turned_rad[j];
    if (j < recording.trajectory.size()) stop.T_G_base = recording.trajectory[j];
    if (j < recording.too_far.size()) stop.too_far = recording.too_far[j];
  }
  for (const PatchCells& patch : recording.patches) {
    out[static_cast<std::size_t>(patch.stop)].patches.push_back(patch);
  }
  return out;
}

}  // namespace rigcal
