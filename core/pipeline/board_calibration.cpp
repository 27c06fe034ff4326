#include "core/pipeline/board_calibration.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/text.h"
#include "core/board/board_adjustment.h"
#include "core/board/board_halves.h"
#include "core/board/markers.h"
#include "core/pipeline/board_finding.h"
#include "core/pipeline/board_losses.h"
#include "core/pipeline/board_verdict.h"
#include "core/pipeline/stage_clock.h"
#include "core/quality/verdict_text.h"

namespace rigcal {
namespace {

constexpr double wrong_scale = 0.02;
constexpr std::size_t least_for_hold_out = 8;  // boards, of which every fourth is held out

/// How a sensor came to its place.
struct Placed {
  bool known = false;
  int via = -1;
  PairPlacementByBoards pair;
};

class BoardCalibration {
 public:
  BoardCalibration(const Rig& rig, const BoardRecording& recording, const std::vector<std::optional<SE3>>& guess,
                   const BoardCalibrationOptions& options, const RunContext& context)
      : rig_(rig),
        recording_(recording),
        guess_(guess),
        options_(options),
        context_(context),
        board_(*rig.board),
        seen_(rig.sensors.size()),
        placed_(rig.sensors.size()) {}

  Expected<CalibrationResult> run() {
    find_boards();
    if (context_.cancelled()) return cancelled_error();
    clock_.begin("placement");
    place_all();
    if (context_.cancelled()) return cancelled_error();
    if (options_.refine_intrinsics) place_by_better_intrinsics();
    check_scale();
    if (context_.cancelled()) return cancelled_error();
    adjust();
    hold_out();
    if (context_.cancelled()) return cancelled_error();
    try_focal_lengths();
    if (context_.cancelled()) return cancelled_error();
    clock_.begin("halves");
    halves_ = compare_board_halves(found_, board_, adjust_options_);
    if (context_.cancelled()) return cancelled_error();
    return conclude();
  }

 private:
  void find_boards() {
    StageReport& stage = clock_.begin("boards");
    context_.reporter.progress("boards", -1.0);
    for (std::size_t s = 0; s < seen_.size(); ++s) {
      if (!rig_.sensors[s].is_lidar()) continue;
      seen_[s] = find_lidar_boards(rig_, static_cast<int>(s), recording_.patches, board_, options_.seed, context_);
    }
    for (const CameraRecording& camera : recording_.cameras) {
      at(camera.sensor) = find_camera_boards(rig_, camera, board_, options_.refine_intrinsics, context_);
    }
    for (std::size_t s = 0; s < seen_.size(); ++s) {
      std::set<int> stops;
      for (const BoardSighting& b : seen_[s].sightings) stops.insert(b.stop);
      stage.counts.emplace_back(rig_.sensors[s].name, static_cast<double>(stops.size()));
      if (!seen_[s].why_part.empty()) {
        context_.reporter.warn(rig_.sensors[s].name + ": " + commonest_reason(seen_[s].why_part, recording_.stops) +
                               "; parts are used where the other sensors tell which part it is");
      }
      all_.insert(all_.end(), seen_[s].sightings.begin(), seen_[s].sightings.end());
    }
    // Cameras alone do not mind the unit, but what is asked of a result is in metres.
    if (!can_be_metres(board_.square())) {
      context_.reporter.warn("board.square is " + number_text(board_.square()) +
                             ", and bounds and --require are in metres; give it in metres, too, where statuses matter");
    }
    doubt_ = doubt_of_corners(all_, board_);
  }

  void check_scale() {
    scale_ = scale_between(all_);
    if (scale_ > 0.0 && std::abs(scale_ - 1.0) > wrong_scale) {
      context_.reporter.warn("by the LiDARs the squares of the board measure " + number(scale_ * board_.square(), 4) +
                             " m, but the rig file's board.square is " + number(board_.square(), 4) + "; measure them");
    }
  }

  [[nodiscard]] SensorBoards& at(int sensor) { return seen_[static_cast<std::size_t>(sensor)]; }

  // Sensor after sensor, always the one that shares most boards with one that is placed.
  void place_all() {
    sensors_.assign(rig_.sensors.size(), {});
    placed_.assign(rig_.sensors.size(), {});
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      sensors_[s].name = rig_.sensors[s].name;
      sensors_[s].camera = seen_[s].camera;
      sensors_[s].fixed = static_cast<int>(s) == rig_.base;
    }
    placed_[static_cast<std::size_t>(rig_.base)].known = true;
    for (;;) {
      std::size_t best = sensors_.size();
      Placed how;
      for (std::size_t s = 0; s < sensors_.size(); ++s) {
        if (placed_[s].known) continue;
        for (std::size_t via = 0; via < sensors_.size(); ++via) {
          if (!placed_[via].known) continue;
          std::optional<SE3> guess;
          if (guess_[s] && guess_[via]) guess = guess_[via]->inverse() * *guess_[s];
          const auto pair = place_pair(all_, static_cast<int>(via), static_cast<int>(s), board_, guess);
          if (!pair || pair->agreeing == 0 || (how.known && pair->agreeing <= how.pair.agreeing)) continue;
          how = {true, static_cast<int>(via), *pair};
          best = s;
        }
      }
      if (best == sensors_.size()) break;
      placed_[best] = how;
      sensors_[best].T_base_sensor = sensors_[static_cast<std::size_t>(how.via)].T_base_sensor * how.pair.T_a_b;
    }
    std::vector<char> is_placed;
    for (const Placed& p : placed_) is_placed.push_back(p.known ? 1 : 0);
    places_ = board_places(all_, sensors_, board_, is_placed);
    // Boards that one sensor alone saw tell of its intrinsics, and else of nothing.
    if (!options_.refine_intrinsics) std::erase_if(places_, [](const BoardPlace& p) { return p.sightings.size() < 2; });
  }

  // Rough intrinsics place boards so roughly that sightings of one no longer meet: with those that the others give, all
  // are looked at once more.
  void place_by_better_intrinsics() {
    adjust_options_.refine_intrinsics = true;
    const BoardAdjustment first = adjust_boards(sensors_, places_, board_, adjust_options_);
    if (!first.converged) return;
    for (BoardSighting& seen : all_) {
      const auto s = static_cast<std::size_t>(seen.sensor);
      if (!seen.image || first.observable[s] == 0) continue;
      seen_[s].camera = first.sensors[s].camera;
      const CameraModel model(*seen_[s].camera);
      if (const std::optional<ImagePose> pose = find_image_pose(*seen.image, board_, model)) {
        seen = image_sighting(seen.sensor, seen.stop, *seen.image, *pose, board_, model);
      }
    }
    place_all();
  }

  void adjust() {
    StageReport& stage = clock_.begin("adjustment");
    adjust_options_.refine_intrinsics = options_.refine_intrinsics;
    found_ = adjust_boards(sensors_, places_, board_, adjust_options_);
    stage.iterations = found_.iterations;
    stage.cost_before = found_.cost_before;
    stage.cost_after = found_.cost_after;
    double held = 0.0;
    for (const BoardPlace& place : found_.places) {
      held += place.why_out.empty() && place.sightings.size() > 1 ? 1.0 : 0.0;
      if (place.why_out.empty()) continue;
      left_out_.insert(place.stop);
      context_.reporter.warn("stop " + std::to_string(stop_number(place.stop)) + " was left out: " + place.why_out);
    }
    stage.counts = {{"boards", held}, {"chi2", found_.chi2}};
    for (const BoardSensor& s : found_.sensors) {
      if (s.camera) {
        stage.counts.emplace_back(s.name + "_px", s.sigma_px);
      } else {
        stage.counts.emplace_back(s.name + "_plane_mm", 1e3 * s.sigma_plane_m);
        stage.counts.emplace_back(s.name + "_border_mm", 1e3 * s.sigma_border_m);
        stage.counts.emplace_back(s.name + "_range_offset_mm", 1e3 * s.range_offset_m);
      }
    }
    for (const std::string& finding : findings_of(found_, board_)) context_.reporter.warn(finding);
  }

  [[nodiscard]] int stop_number(int stop) const { return recording_.stops[static_cast<std::size_t>(stop)].index; }

  // Every fourth board apart: the sensors' places come from the others, and only its own pose is fitted to it.
  void hold_out() {
    hold_out_.assign(sensors_.size(), {});
    std::vector<BoardPlace> kept;
    std::vector<BoardPlace> held;
    for (const BoardPlace& place : found_.places) {
      if (!place.why_out.empty() || place.sightings.size() < 2) continue;
      ((kept.size() + held.size()) % 4 == 3 ? held : kept).push_back(place);
    }
    if (kept.size() + held.size() < least_for_hold_out) return;
    clock_.begin("hold-out");
    BoardAdjustOptions options = adjust_options_;
    options.noise_passes = 0;
    options.drop_outliers = false;
    options.refine_intrinsics = false;
    const BoardAdjustment others = adjust_boards(found_.sensors, kept, board_, options);
    options.sensors_fixed = true;
    const BoardAdjustment then = adjust_boards(others.sensors, held, board_, options);
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      const bool is_camera = then.sensors[s].camera.has_value();
      double squares = 0.0;
      double own_squares = 0.0;
      double count = 0.0;
      for (const BoardPlace& place : then.places) {
        for (const BoardSighting& seen : place.sightings) {
          if (static_cast<std::size_t>(seen.sensor) != s) continue;
          const SightingResiduals left = residuals_of(seen, then.sensors[s], place.T_base_board, board_);
          squares += std::pow(left.normalised, 2);
          own_squares += std::pow(is_camera ? left.pixels : left.plane_m, 2);
          count += 1.0;
        }
      }
      if (count == 0.0) continue;
      hold_out_[s] = {std::sqrt(squares / count), std::sqrt(own_squares / count), 0.0, is_camera ? "px" : "m"};
    }
  }

  // A wrong focal length is taken up by the camera's place and the ranges, and no residual shows it.
  void try_focal_lengths() {
    focal_.assign(sensors_.size(), {});
    if (options_.refine_intrinsics) return;
    clock_.begin("focal lengths");
    BoardAdjustOptions options = adjust_options_;
    options.noise_passes = 0;
    options.drop_outliers = false;
    options.free_focal_lengths = true;
    const BoardAdjustment free = adjust_boards(found_.sensors, found_.places, board_, options);
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      const BoardSensor& sensor = free.sensors[s];
      if (!sensor.camera || !free.converged) continue;
      focal_[s].off = found_.sensors[s].camera->fx / sensor.camera->fx - 1.0;
      focal_[s].sigma = free.focal_sigma[s];
      focal_[s].moves_m = (sensor.T_base_sensor.t - found_.sensors[s].T_base_sensor.t).norm();
      focal_[s].moves_rad = rotation_distance(sensor.T_base_sensor.R, found_.sensors[s].T_base_sensor.R);
    }
  }

  [[nodiscard]] std::string why_not_placed(std::size_t s) const {
    const SensorBoards& boards = seen_[s];
    if (!boards.why_not.empty()) return boards.why_not;
    if (boards.views == 0) return "nothing of it is in the recording; record it, too, or take it out of the rig file";
    if (boards.sightings.empty())
      return "no board was found in what it saw: " + commonest_reason(boards.why_none, recording_.stops) +
             "; show it the whole board, with nothing beside or behind its edges, and check board in the rig file";
    const auto base = static_cast<std::size_t>(rig_.base);
    if (seen_[base].sightings.empty()) {
      return "the board was found in what it saw, but not in what " + rig_.sensors[base].name +
             ", the base, saw; see the reasons of that, or name another base in the rig file";
    }
    return "the board was found in what it saw, but at no stop at which a sensor that is placed saw it as well; "
           "show it to both at once";
  }

  [[nodiscard]] bool saw_several(std::size_t s) const {
    std::set<int> stops;
    for (const BoardSighting& b : seen_[s].sightings) {
      if (!stops.insert(b.stop).second) return true;
    }
    return false;
  }

  [[nodiscard]] int shared_places(std::size_t a, std::size_t b) const {
    std::set<int> stops;
    for (const BoardPlace& place : found_.places) {
      const auto saw = [&](std::size_t sensor) {
        return std::any_of(place.sightings.begin(), place.sightings.end(), [&](const BoardSighting& sighting) {
          return static_cast<std::size_t>(sighting.sensor) == sensor;
        });
      };
      if (place.why_out.empty() && saw(a) && saw(b)) stops.insert(place.stop);
    }
    return static_cast<int>(stops.size());
  }

  [[nodiscard]] BoardLosses losses_of(std::size_t s) const {
    return lost_boards(static_cast<int>(s), placed_[s].via, all_, found_.places);
  }

  void warn_of_lost(std::size_t s) const {
    std::vector<std::string> numbers;
    for (const int stop : losses_of(s).stops) {
      if (!left_out_.contains(stop)) numbers.push_back(std::to_string(stop_number(stop)));
    }
    if (numbers.empty()) return;
    context_.reporter.warn((numbers.size() == 1 ? "stop " : "stops ") + joined(numbers, ", ") +
                           (numbers.size() == 1 ? " holds" : " hold") + " nothing of " + rig_.sensors[s].name +
                           ": the board that it saw there goes with no other sensor's");
  }

  [[nodiscard]] Verdict blind(std::size_t s) const {
    Verdict verdict;
    fail(verdict, why_not_placed(s));
    return verdict;
  }

  [[nodiscard]] BoardEvidence evidence_of(std::size_t s) const {
    const auto via = static_cast<std::size_t>(placed_[s].via);
    BoardEvidence e;
    e.name = rig_.sensors[s].name;
    e.via = rig_.sensors[via].name;
    e.shared = placed_[s].pair.shared;
    // Boards that the adjustment took for others no longer hold it.
    e.agreeing = std::min(placed_[s].pair.agreeing, shared_places(s, via));
    e.runner_up = placed_[s].pair.runner_up;
    e.several_boards = saw_several(s) || saw_several(via);
    e.covariance = found_.covariances[s];
    e.observable = found_.observable[s] != 0;
    e.converged = found_.converged;
    e.hold_out = hold_out_[s].ratio;
    if (placed_[s].via != rig_.base) {
      e.via_failed = judge(via).status == Status::failed;
      e.via_agreeing =
          std::min(placed_[via].pair.agreeing, shared_places(via, static_cast<std::size_t>(placed_[via].via)));
    }
    e.halves = halves_[s];
    e.halves.first_later_stop = stop_number(e.halves.first_later_stop);
    e.focal = focal_[s];
    const BoardLosses lost = losses_of(s);
    for (const int stop : lost.stops) e.lost.push_back(stop_number(stop));
    e.lost_together = lost.together;
    return e;
  }

  [[nodiscard]] Verdict judge(std::size_t s) const {
    if (!placed_[s].known) return blind(s);
    Verdict out = judge_by_boards(evidence_of(s), options_.require, advice_on_poses(found_, s));
    if (out.status != Status::failed && scale_ > 0.0 && std::abs(scale_ - 1.0) > wrong_scale) {
      weaken(out, "the board's squares have another size than the rig file says (see the warnings); measure them");
    }
    if (!doubt_.empty()) {
      // Corners that are taken for others shift the board alike in all images, which no residual shows.
      out.status = std::max(out.status, Status::weak);
      out.reasons.insert(out.reasons.begin(), doubt_);
    }
    return out;
  }

  CalibrationResult conclude() {
    clock_.begin("verdict");
    CalibrationResult result;
    result.base = rig_.base_sensor().name;
    result.method = "checkerboard";
    result.status = Status::good;
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      SensorResult sensor{rig_.sensors[s].name, Status::good, {}, SE3{}};
      sensor.guess_T_base_sensor = guess_[s];
      const bool is_blind_base = static_cast<int>(s) == rig_.base && seen_[s].sightings.empty();
      if (static_cast<int>(s) != rig_.base || is_blind_base) {
        const Verdict verdict = is_blind_base ? blind(s) : judge(s);
        if (placed_[s].known && !is_blind_base) warn_of_lost(s);
        sensor.status = verdict.status;
        sensor.reasons = verdict.reasons;
        sensor.T_base_sensor.reset();
        if (verdict.status != Status::failed) {
          sensor.T_base_sensor = found_.sensors[s].T_base_sensor;
          sensor.covariance = found_.covariances[s];
        }
      }
      if (sensor.T_base_sensor && !found_.sensors[s].camera) sensor.range_offset = remarkable_offset(found_, s);
      result.status = std::max(result.status, sensor.status);
      sensor.hold_out = hold_out_[s];
      if (rig_.sensors[s].camera) add_camera(s, result);
      result.sensors.push_back(std::move(sensor));
    }
    for (std::size_t j = 0; j < recording_.stops.size(); ++j) {
      result.trajectory.push_back({recording_.stops[j], SE3{}, false});
    }
    for (const BoardPlace& place : found_.places) {
      const bool held = place.why_out.empty() && place.sightings.size() > 1;
      if (held) result.trajectory[static_cast<std::size_t>(place.stop)].took_part = true;
    }
    for (const Patch& patch : recording_.patches) {
      const std::string& name = rig_.sensors[static_cast<std::size_t>(patch.sensor)].name;
      result.trajectory[static_cast<std::size_t>(patch.stop)].points[name] += patch.points.size();
    }
    result.stages = clock_.take();
    return result;
  }

  void add_camera(std::size_t s, CalibrationResult& result) const {
    CameraEvidence evidence;
    evidence.name = rig_.sensors[s].name;
    evidence.guess_T_base_camera = guess_[s];
    evidence.images = seen_[s].images;
    evidence.given = rig_.sensors[s].camera->intrinsics.value_or(found_.sensors[s].camera.value_or(CameraIntrinsics{}));
    if (!found_.sensors[s].camera) {
      // Nothing was looked for; still it is a camera, and no LiDAR.
      result.cameras.push_back(std::move(evidence));
      return;
    }
    evidence.refined_intrinsics = options_.refine_intrinsics;
    evidence.estimate.found = placed_[s].known;
    evidence.estimate.converged = found_.converged;
    evidence.estimate.intrinsics = *found_.sensors[s].camera;
    evidence.estimate.pose = {found_.sensors[s].T_base_sensor, found_.covariances[s]};
    evidence.estimate.views = static_cast<int>(seen_[s].images.size());
    evidence.estimate.residual_px = found_.sensors[s].sigma_px;
    evidence.estimate.hold_out = hold_out_[s].ratio;
    evidence.estimate.hold_out_px = hold_out_[s].rms;
    result.cameras.push_back(std::move(evidence));
  }

  const Rig& rig_;
  const BoardRecording& recording_;
  const std::vector<std::optional<SE3>>& guess_;
  const BoardCalibrationOptions& options_;
  const RunContext& context_;
  BoardModel board_;
  std::vector<SensorBoards> seen_;  ///< By sensor of the rig, as all below.
  std::vector<BoardSighting> all_;
  std::vector<Placed> placed_;
  std::vector<BoardSensor> sensors_;
  std::vector<BoardPlace> places_;
  BoardAdjustOptions adjust_options_;
  BoardAdjustment found_;
  std::set<int> left_out_;  ///< Stops that the adjustment left out, of which it was warned.
  std::vector<HoldOutFigures> hold_out_;
  std::vector<BoardHalves> halves_;
  std::vector<FocalDoubt> focal_;
  std::string doubt_;  ///< Of the rig file's inner_corners.
  double scale_ = 0.0;
  StageClock clock_;
};

}  // namespace

Expected<void> check_board(const Rig& rig) {
  if (!rig.board) {
    return input_error("the rig file has no board", {},
                       "add board: {type: checkerboard, inner_corners: [columns, rows], square: metres, size: [width, "
                       "height]}");
  }
  if (rig.board->dictionary.empty() || knows_markers()) return {};
  return input_error(
      "the board has markers, and this rigcal was built without OpenCV's aruco module, by which they are known", {},
      "build it where libopencv-contrib-dev is installed, or show a plain checkerboard");
}

Expected<CalibrationResult> calibrate_by_boards(const Rig& rig, const BoardRecording& recording,
                                                const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                                                const BoardCalibrationOptions& options, const RunContext& context) {
  if (const Expected<void> fit = check_board(rig); !fit) return fit.error();
  if (recording.stops.empty()) return input_error("there is no stop at which a board could be seen");
  return BoardCalibration(rig, recording, guess_T_base_sensor, options, context).run();
}

}  // namespace rigcal
