#include "core/pipeline/camera_stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"
#include "core/camera/camera_minima.h"
#include "core/camera/map_samples.h"
#include "core/camera/sample_blocks.h"
#include "core/camera/working_size.h"
#include "core/edges/grey_image.h"
#include "core/edges/outlines.h"
#include "core/pipeline/camera_mixups.h"
#include "core/pipeline/camera_trust.h"
#include "core/pipeline/late_images.h"
#include "core/pipeline/stage_clock.h"
#include "core/quality/camera_verdict.h"
#include "core/quality/verdict_text.h"
#include "core/report/overlay.h"
#include "core/start/axis_search.h"

namespace rigcal {
namespace {

// From fewer images nothing is held out, and a camera is not good: other guesses and other stops are not tried.
constexpr int least_views = 4;
// Guesses are off by more than this only where they are wrong.
constexpr double farthest_sigmas = 2.0;

// An image whose values differ by less shows nothing but noise.
constexpr float min_spread = 6.0F;

std::string blankness(const GreyImage& grey) {
  const float value = grey.values[grey.values.size() / 2];
  return value < 32.0F ? "black" : (value > 224.0F ? "white" : "grey without anything in it");
}

SensorResult failed(const std::string& name, std::string reason) {
  return {name, Status::failed, {std::move(reason)}, std::nullopt, Matrix6d::Zero()};
}

// What is missing before a camera's images need be looked at; empty: nothing.
std::string missing(const Sensor& sensor) {
  if (!sensor.camera->intrinsics) {
    return "the rig file has no intrinsics for it; put in intrinsics: {model: radtan, width, height, fx, fy, cx, cy, "
           "distortion: [k1, k2, p1, p2, k3]} from a calibration of the camera alone";
  }
  return {};
}

std::size_t place_of(const std::string& name, const std::vector<SensorResult>& sensors) {
  const auto at = std::find_if(sensors.begin(), sensors.end(), [&](const SensorResult& s) { return s.name == name; });
  return static_cast<std::size_t>(at - sensors.begin());
}

// The cameras' sensors among the LiDARs', as the rig file has them.
void insert_in_order(const Rig& rig, const std::vector<SensorResult>& cameras, CalibrationResult& result) {
  std::vector<SensorResult> all;
  for (const Sensor& sensor : rig.sensors) {
    const std::size_t lidar = place_of(sensor.name, result.sensors);
    const std::size_t camera = place_of(sensor.name, cameras);
    if (lidar < result.sensors.size()) {
      all.push_back(result.sensors[lidar]);
    } else if (camera < cameras.size()) {
      all.push_back(cameras[camera]);
    }
  }
  result.sensors = std::move(all);
}

BeamWidth beam_of(LidarModel model) {
  const LidarFacts& facts = facts_of(model);
  if (facts.beam_upright_deg <= 0.0) return {};
  return {to_rad(facts.beam_upright_deg), to_rad(facts.beam_level_deg)};
}

Vector3d middle_of_placed(const std::vector<PatchCells>& patches, const RigState& state, const std::vector<char>& use) {
  std::vector<char> placed(state.T_base_sensor.size(), 0);
  for (std::size_t k = 0; k < patches.size(); ++k) {
    if (use.empty() || use[k] != 0) placed[static_cast<std::size_t>(patches[k].lidar)] = 1;
  }
  Vector3d sum = Vector3d::Zero();
  double count = 0.0;
  for (std::size_t lidar = 0; lidar < placed.size(); ++lidar) {
    if (placed[lidar] == 0) continue;
    sum += state.T_base_sensor[lidar].t;
    count += 1.0;
  }
  return sum / std::max(1.0, count);
}

std::optional<RigTurn> turn_of(const LidarSolution& solution, const std::vector<PatchCells>& patches) {
  const auto found = turn_of_poses(solution.state.T_G_base, solution.start.stop_known);
  if (!found || found->drove()) return std::nullopt;
  const Vector3d& axis = found->turn.axis;
  const Vector3d middle = middle_of_placed(patches, solution.state, solution.use);
  return RigTurn{axis, found->turn.foot + axis * axis.dot(middle)};
}

class CameraStage {
 public:
  CameraStage(const Rig& rig, const LidarRecording& recording, const LidarSolution& solution,
              const Requirement& require, const CameraCalibrationOptions& options, const RunContext& context,
              CalibrationResult& result)
      : rig_(rig),
        recording_(recording),
        solution_(solution),
        require_(require),
        options_(options),
        context_(context),
        result_(result) {}

  Expected<SensorResult> run(const CameraRecording& camera) {
    ImageMarks& marks = marks_.emplace_back();
    const Sensor& sensor = rig_.sensors[static_cast<std::size_t>(camera.sensor)];
    if (std::string reason = missing(sensor); !reason.empty()) return failed(sensor.name, std::move(reason));
    clock_.begin(sensor.name + " images");
    context_.reporter.progress(sensor.name, -1.0);
    const int halvings = halvings_of(*sensor.camera->intrinsics);
    CameraTask task{
        camera.sensor, sensor.name, halved(*sensor.camera->intrinsics, halvings), camera.guess_T_base_camera, {}};
    StillImages still = camera.read_images(context_);
    leave_out_lost_stops(still);
    task.views = camera_views(still.images, halvings, sensor.name, context_);
    if (context_.cancelled()) return cancelled_error();
    if (task.views.empty()) {
      return failed(sensor.name, still.images.empty() ? still.why_none
                                                      : "none of its images shows anything; check lens cap, aperture "
                                                        "and exposure");
    }
    marks = image_marks(task.views);
    warn_of_repeated(task, marks);
    if (scene_.T_G_base.empty()) make_scene();
    StageReport& stage = clock_.begin(sensor.name);
    stage.counts.emplace_back("images", static_cast<double>(task.views.size()));
    Expected<CameraEstimate> estimate = estimate_of(task, options_);
    if (!estimate) return estimate.error();
    Verdict verdict = judge(task, *estimate);
    if (verdict.status == Status::failed && estimate->views >= least_views) {
      keep_edges(task.views);
      if (const Expected<void> tried = try_without_guess(task, *estimate, verdict); !tried) return tried.error();
    }
    // Last, since with equal steps of the table a guess that is off by one of them looks like that, too.
    if (verdict.status == Status::failed && estimate->views >= least_views) {
      if (const Expected<void> tried = try_other_stops(task, *estimate, verdict); !tried) return tried.error();
    }
    if (verdict.status == Status::good) warn_of_unlike(*estimate);
    tell(*estimate, stage);
    for (Overlay& overlay : draw_overlays(scene_, task, *estimate)) result_.overlays.push_back(std::move(overlay));
    SensorResult found = conclude(task, in_full(task, std::move(*estimate)), verdict);
    if (found.T_base_sensor) keep_colours(still.images);
    return found;
  }

  // Of each camera that was run.
  [[nodiscard]] const std::vector<ImageMarks>& marks() const { return marks_; }

  void finish() {
    if (!colours_.empty()) {
      StageReport& stage = clock_.begin("map colours");
      context_.reporter.progress("map colours", -1.0);
      stage.counts.emplace_back("images", static_cast<double>(colours_.size()));
      result_.map_rgb = colour_map(result_.map, colours_, scene_.samples, scene_.blocks);
    }
    result_.edges = std::move(scene_.edges);
    tell_stages();
  }

  void tell_stages() {
    for (StageReport& stage : clock_.take()) result_.stages.push_back(std::move(stage));
  }

 private:
  // The pose of the rig is not known there.
  void leave_out_lost_stops(StillImages& still) const {
    const std::size_t before = still.images.size();
    std::erase_if(still.images, [&](const StillImage& image) {
      return solution_.start.stop_known[static_cast<std::size_t>(image.stop)] == 0;
    });
    if (still.images.empty() && before > 0) {
      still.why_none =
          "all of its images were taken at stops that were left out, since their poses are not known; mend what "
          "the warnings say of these stops";
    }
  }

  // A late image, or a camera that hung for a while: which of them is of its stop nobody knows here.
  void warn_of_repeated(const CameraTask& task, const ImageMarks& marks) const {
    const std::vector<std::size_t> same = repeated_images(marks);
    if (same.empty()) return;
    context_.reporter.warn(task.views[same[1]].file + ": the image is the same as " + task.views[same[0]].file +
                           (same.size() > 2 ? " (at " + std::to_string(same.size()) + " stops in all)" : "") + ": " +
                           task.name +
                           " hung, or its images came late, so that others may be of the stop before, too; leave out "
                           "what was not taken at its stop, or record anew");
  }

  // Too few to say anything against the camera.
  void warn_of_unlike(const CameraEstimate& estimate) const {
    for (const std::string& file : unlike_images(estimate)) {
      context_.reporter.warn(file +
                             ": the image shows next to none of the edges that those of other stops show of the "
                             "same place; something stood before the camera, or it was taken elsewhere or is too "
                             "dark or blurred; look at it, and leave it out if it is not of its stop");
    }
  }

  // With the pose and the intrinsics that were just found.
  void keep_colours(const std::vector<StillImage>& images) {
    const CameraEstimate& estimate = result_.cameras.back().estimate;
    const CameraModel model(estimate.intrinsics);
    std::vector<ColourPicture> pictures = colour_pictures(images);
    for (std::size_t k = 0; k < images.size(); ++k) {
      const SE3 T_G_C = scene_.T_G_base[static_cast<std::size_t>(images[k].stop)] * estimate.pose.T_base_camera;
      colours_.push_back({model, T_G_C.inverse(), std::move(pictures[k]), result_.cameras.size() - 1});
    }
  }

  // Not before there is an image to be matched: it takes as long as a camera.
  void make_scene() {
    StageReport& stage = clock_.begin("edges");
    context_.reporter.progress("edges", -1.0);
    scene_ = make_camera_scene(rig_, recording_, solution_);
    stage.counts = {{"lidar_edge_points", static_cast<double>(scene_.edges.size())},
                    {"map_samples", static_cast<double>(scene_.samples.size())}};
  }

  void tell(const CameraEstimate& estimate, StageReport& stage) const {
    stage.iterations = estimate.iterations;
    stage.counts.emplace_back("images_with_edges", estimate.views_with_edges);
    stage.counts.emplace_back("lidar_edge_points", static_cast<double>(scene_.edges.size()));
    stage.counts.emplace_back("matched_edge_points", static_cast<double>(estimate.edge_points));
    stage.counts.emplace_back("segments", static_cast<double>(estimate.segments));
  }

  // What is tried several times looks for them once.
  static void keep_edges(std::vector<CameraView>& views) {
    parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        if (views[k].edges == nullptr)
          views[k].edges = std::make_shared<const std::vector<ImageEdge>>(find_image_edges(views[k].grey));
      }
    });
  }

  [[nodiscard]] Expected<CameraEstimate> estimate_of(const CameraTask& task,
                                                     const CameraCalibrationOptions& options) const {
    Expected<CameraEstimate> estimate = calibrate_camera(scene_, task, options, context_);
    if (estimate) widen_by_unevenness(task.views, solution_, estimate->pose);
    return estimate;
  }

  [[nodiscard]] const CameraIntrinsics& given(const CameraTask& task) const {
    return *rig_.sensors[static_cast<std::size_t>(task.sensor)].camera->intrinsics;
  }

  [[nodiscard]] CameraEstimate in_full(const CameraTask& task, CameraEstimate estimate) const {
    return at_full_size(std::move(estimate), given(task), halvings_of(given(task)));
  }

  [[nodiscard]] Verdict judge(const CameraTask& task, const CameraEstimate& estimate) const {
    CameraThresholds limits;
    const double scale = std::ldexp(1.0, halvings_of(given(task)));
    limits.worse_px *= scale;
    limits.radial_trend_px *= scale;
    limits.centre_chance_px *= scale;
    return judge_camera(in_full(task, estimate), task.name, require_, options_.refine_intrinsics, limits);
  }

  // Whether images are counted a stop late or early is told by where they are good then. That pose is not taken: where
  // one number is wrong, others may be. At their own stops images show more of the map's edges.
  Expected<void> try_other_stops(const CameraTask& task, const CameraEstimate& own, Verdict& verdict) const {
    CameraCalibrationOptions options = options_;
    options.beaten_start_score = own.start_score;
    for (const int by : {-1, 1}) {
      CameraTask moved{task.sensor, task.name, task.intrinsics, task.guess_T_base_camera,
                       views_moved(task.views, by, solution_.start.stop_known)};
      const Expected<CameraEstimate> estimate = estimate_of(moved, options);
      if (!estimate) return estimate.error();
      if (judge(moved, *estimate).status != Status::good) continue;
      verdict.reasons = {wrong_stops_words(by)};
      break;
    }
    return {};
  }

  // Where a guess leads to no end, or to a false one, it may be wrong itself (a camera that is mounted upside down),
  // and images that go without it tell. What they find is taken where it is good by its own evidence.
  Expected<void> try_without_guess(CameraTask& task, CameraEstimate& estimate, Verdict& verdict) const {
    if (!task.guess_T_base_camera) return {};
    const std::optional<SE3> guess = std::exchange(task.guess_T_base_camera, std::nullopt);
    Expected<CameraEstimate> free = estimate_of(task, options_);
    task.guess_T_base_camera = guess;
    if (!free) return free.error();
    const Verdict found = judge(task, *free);
    if (found.status == Status::failed) return {};
    const SE3& T_base_camera = free->pose.T_base_camera;
    const std::string away = mm((T_base_camera.t - guess->t).norm()) + " and " +
                             deg(rotation_distance(T_base_camera.R, guess->R)) + " from its initial_extrinsics";
    if (found.status == Status::weak) {
      verdict.reasons.push_back("its images alone lead to a pose that is weak, " + away +
                                ": if that may be so, mend these, or leave them out");
      return {};
    }
    free->iterations += estimate.iterations;
    free->wall_s += estimate.wall_s;
    estimate = std::move(*free);
    verdict = found;
    if (!is_within(*guess, T_base_camera, farthest_sigmas * options_.guess_sigma_rad,
                   farthest_sigmas * options_.guess_sigma_m)) {
      weaken(verdict,
             "its images alone lead to this pose, " + away + ", which lead to none: check them, or leave them out");
    }
    return {};
  }

  SensorResult conclude(const CameraTask& task, CameraEstimate estimate, Verdict verdict) {
    if (verdict.status != Status::failed && solution_.start.has_assumed_steps) weaken(verdict, assumed_steps_words());
    // Halves and grey values were compared by what edges alone tell.
    rest_on_given_stops(task.views, recording_, solution_, estimate.pose, verdict);
    SensorResult sensor{task.name, verdict.status, verdict.reasons, std::nullopt, Matrix6d::Zero()};
    sensor.guess_T_base_sensor = task.guess_T_base_camera;
    sensor.hold_out = {estimate.hold_out, estimate.hold_out_px, estimate.hold_out_start_px, "px"};
    if (verdict.status != Status::failed) {
      sensor.T_base_sensor = estimate.pose.T_base_camera;
      sensor.covariance = estimate.pose.covariance;
    }
    CameraEvidence evidence{task.name, task.guess_T_base_camera, given(task), options_.refine_intrinsics, {}, {}};
    for (const CameraView& view : task.views) evidence.images.push_back({view.stop, view.file});
    evidence.estimate = std::move(estimate);
    result_.cameras.push_back(std::move(evidence));
    return sensor;
  }

  const Rig& rig_;
  const LidarRecording& recording_;
  const LidarSolution& solution_;
  const Requirement& require_;
  const CameraCalibrationOptions& options_;
  const RunContext& context_;
  CalibrationResult& result_;
  CameraScene scene_;
  std::vector<ImageMarks> marks_;
  std::vector<ColourView> colours_;
  StageClock clock_;
};

// The scale of each image of a camera: of those of 16 bits that which holds the largest value of them all, or what is
// darker at one stop would be as bright there as elsewhere.
std::vector<int> bits_of(const std::vector<StillImage>& images) {
  std::vector<int> bits(images.size());
  parallel_for(images.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) bits[k] = value_bits(images[k].image);
  });
  const int most = bits.empty() ? 0 : *std::max_element(bits.begin(), bits.end());
  for (std::size_t k = 0; k < images.size(); ++k) {
    if (images[k].image.bits != 8) bits[k] = most;
  }
  return bits;
}

// Of fewer stops much is seen by one patch alone, and little of a room by two of them.
constexpr std::size_t least_stops_seen_twice = 4;

std::size_t stops_of(const std::vector<PatchCells>& patches, const std::vector<char>& use) {
  std::vector<int> stops;
  for (std::size_t k = 0; k < patches.size(); ++k) {
    if (use[k]) stops.push_back(patches[k].stop);
  }
  std::sort(stops.begin(), stops.end());
  return static_cast<std::size_t>(std::unique(stops.begin(), stops.end()) - stops.begin());
}

// Those of the map, and what one patch alone sees: it says nothing of poses, and is there once they are known.
std::vector<PlaneFeature> leaves_of_all(const LidarRecording& recording, const LidarSolution& solution) {
  PlaneMapOptions options;
  options.min_patches = 1;
  if (solution.unevenness_m > 0.0) {
    options.offset_floor_m = std::max(options.offset_floor_m, solution.unevenness_m);
    options.gate_slack_m = solution.unevenness_m;
    options.max_chi2 = 3.0;
  }
  std::vector<PlaneFeature> leaves = build_plane_map(solution.patches(recording), solution.state, solution.noise,
                                                     solution.T_grid_G, options, solution.use)
                                         .features;
  std::erase_if(leaves, [](const PlaneFeature& leaf) { return leaf.observations.size() > 1; });
  const std::vector<PlaneFeature>& shared = solution.refined.map.features;
  leaves.insert(leaves.begin(), shared.begin(), shared.end());
  return leaves;
}

}  // namespace

std::vector<BeamWidth> beam_widths(const Rig& rig, const std::vector<int>& lidar_sensors) {
  std::vector<BeamWidth> beams;
  for (const int sensor : lidar_sensors) {
    beams.push_back(beam_of(rig.sensors[static_cast<std::size_t>(sensor)].lidar->model));
  }
  return beams;
}

ImageFeatures find_features(const Image& image, int halvings) {
  ImageFeatures features{halved(to_grey(image, value_bits(image)), halvings), nullptr, halvings};
  features.edges = std::make_shared<const std::vector<ImageEdge>>(find_image_edges(features.grey));
  return features;
}

CameraScene make_camera_scene(const Rig& rig, const LidarRecording& recording, const LidarSolution& solution,
                              const std::stop_token& stop) {
  CameraScene scene;
  scene.T_G_base = solution.state.T_G_base;
  scene.stop_known = solution.start.stop_known;
  scene.turn = turn_of(solution, solution.patches(recording));
  std::vector<PlaneFeature> all;
  const bool is_seen_twice = stops_of(solution.patches(recording), solution.use) >= least_stops_seen_twice;
  if (!is_seen_twice) all = leaves_of_all(recording, solution);
  const std::vector<PlaneFeature>& leaves = is_seen_twice ? solution.refined.map.features : all;
  scene.edges = find_lidar_edges(leaves, solution.patches(recording), solution.state, solution.noise, solution.use);
  int lines = 0;
  for (const LidarEdge& edge : scene.edges) lines = std::max(lines, edge.line + 1);
  if (stop.stop_requested()) return scene;
  // Those found before are of the ranges as they were measured.
  const bool is_known = solution.corrected.empty() && !recording.outlines.empty();
  for (LidarEdge& edge :
       find_outlines(solution.patches(recording), solution.state, solution.use, lines,
                     beam_widths(rig, recording.lidar_sensors), is_known ? &recording.outlines : nullptr)) {
    scene.edges.push_back(edge);
  }
  if (stop.stop_requested()) return scene;
  scene.samples = sample_map(solution.patches(recording), solution.state, solution.use, leaves);
  scene.blocks = blocks_of(scene.samples);
  return scene;
}

std::vector<CameraView> camera_views(const std::vector<StillImage>& images, int halvings, const std::string& camera,
                                     const RunContext& context) {
  const std::vector<int> bits = bits_of(images);
  std::vector<CameraView> views(images.size());
  std::vector<char> blank(images.size(), 0);
  parallel_for(images.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const ImageFeatures* known = images[k].features.get();
      if (known != nullptr && known->halvings == halvings && bits[k] == value_bits(images[k].image)) {
        views[k] = {images[k].stop, images[k].file, known->grey, known->edges};
      } else {
        views[k] = {images[k].stop, images[k].file, halved(to_grey(images[k].image, bits[k]), halvings), nullptr};
      }
      blank[k] = grey_spread(views[k].grey) < min_spread;
    }
  });
  std::vector<CameraView> kept;
  for (std::size_t k = 0; k < views.size(); ++k) {
    if (blank[k]) {
      context.reporter.warn(views[k].file + ": the image of " + camera + " is " + blankness(views[k].grey) +
                            " and is left out; check lens cap and exposure");
    } else {
      kept.push_back(std::move(views[k]));
    }
  }
  return kept;
}

std::vector<ColourPicture> colour_pictures(const std::vector<StillImage>& images) {
  const std::vector<int> bits = bits_of(images);
  std::vector<ColourPicture> pictures(images.size());
  parallel_for(images.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) pictures[k] = colour_picture(images[k].image, bits[k]);
  });
  return pictures;
}

Expected<void> add_cameras(const Rig& rig, const std::vector<CameraRecording>& cameras, const LidarRecording& recording,
                           const LidarSolution& solution, const Requirement& require,
                           const CameraCalibrationOptions& options, const RunContext& context,
                           CalibrationResult& result, const std::function<void()>& solved) {
  CameraStage stage(rig, recording, solution, require, options, context, result);
  std::vector<SensorResult> found;
  for (const CameraRecording& camera : cameras) {
    Expected<SensorResult> sensor = stage.run(camera);
    if (!sensor) return sensor.error();
    found.push_back(std::move(*sensor));
  }
  tell_mixed_up(stage.marks(), options, found);
  for (const SensorResult& sensor : found) result.status = std::max(result.status, sensor.status);
  insert_in_order(rig, found, result);
  stage.tell_stages();
  solved();
  stage.finish();
  return {};
}

}  // namespace rigcal
