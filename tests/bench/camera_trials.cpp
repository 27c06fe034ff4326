// How well cameras are found, over many starts: `camera_trials SESSION...` reads each simulated session once, solves
// its LiDARs once, and then finds every camera from starts drawn at random around the truth. Run by hand; see
// docs/judge-cameras.md.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/evaluation/known_rig.h"
#include "apps/recording/recording.h"
#include "core/base/random.h"
#include "core/camera/working_size.h"
#include "core/io/output_file.h"
#include "core/quality/camera_verdict.h"
#include "core/report/overlay.h"
#include "tests/bench/trial_statistics.h"

namespace rigcal {
namespace {

struct TrialOptions {
  std::vector<std::string> sessions;
  int trials = 10;
  std::uint64_t seed = 1;
  std::string camera;      ///< Empty: all.
  double start_deg = 5.0;  ///< How far off the start is, in a random direction.
  double start_mm = 100.0;
  double focal_error = 0.0;  ///< Percent; trials go up and down in turn.
  double centre_px = 0.0;    ///< Of the principal point, right and down, then left and up.
  double k1_error = 0.0;
  int alien = 0;            ///< Each so manieth image is that of another stop; 0: none.
  double moved_px = 0.0;    ///< The camera is turned to the right by so many pixels
  double moved_from = 0.6;  ///< from this share of its images on.
  bool no_guess = false;
  bool stay = false;  ///< The start is taken for nearly right, though it is not: a wrong minimum.
  bool refine = false;
  bool reasons = false;
  std::string overlays;
};

struct Camera {
  CameraTask task;
  SE3 T_base_camera_true;
  std::vector<Trial> trials;
  std::vector<CameraEstimate> estimates;
};

// Everything about a session that does not change from trial to trial.
struct TrialSession {
  std::string name;
  KnownRig truth;
  CameraScene scene;
  std::vector<Camera> cameras;
};

std::optional<SE3> true_pose(const KnownRig& truth, const std::string& name) {
  for (const KnownRig::Entry& entry : truth.sensors) {
    if (entry.name == name) return entry.T_base_sensor;
  }
  return std::nullopt;
}

Expected<TrialSession> open_trial_session(const std::string& path, const TrialOptions& options,
                                          const RunContext& context) {
  TrialSession out;
  out.name = std::filesystem::path(path).filename();
  const Expected<KnownRig> truth = load_truth((std::filesystem::path(path) / "ground_truth.yaml").string());
  if (!truth) return truth.error();
  out.truth = *truth;
  CellOptions cells;
  cells.keep_thinned = true;
  const Expected<Recording> recording = read_recording({path, {}, {}}, cells, context);
  if (!recording) return recording.error();
  std::vector<std::optional<SE3>> guess;
  for (const int sensor : recording->lidar.lidar_sensors) {
    const Sensor& s = recording->rig.sensors[static_cast<std::size_t>(sensor)];
    guess.push_back(sensor == recording->rig.base ? SE3{} : s.initial_T_base_sensor);
  }
  std::unique_ptr<LidarSolution> solution;
  const auto lidars = calibrate_lidars(recording->rig, recording->lidar, guess, {}, context, &solution);
  if (!lidars) return lidars.error();
  out.scene = make_camera_scene(recording->rig, recording->lidar, *solution);
  for (const CameraRecording& camera : recording->cameras) {
    const Sensor& sensor = recording->rig.sensors[static_cast<std::size_t>(camera.sensor)];
    const auto T = true_pose(out.truth, sensor.name);
    if (!T || !sensor.camera->intrinsics || (!options.camera.empty() && sensor.name != options.camera)) continue;
    const StillImages still = camera.read_images(context);
    if (still.images.empty()) return input_error(still.why_none, path);
    const int halvings = halvings_of(*sensor.camera->intrinsics);
    CameraTask task{camera.sensor, sensor.name, halved(*sensor.camera->intrinsics, halvings), {}, {}};
    task.views = camera_views(still.images, halvings, sensor.name, context);
    out.cameras.push_back({std::move(task), *T, {}, {}});
  }
  return out;
}

Vector3d random_direction(Random& random) {
  const Vector3d v(random.normal(), random.normal(), random.normal());
  return v.normalized();
}

void spoil(const TrialOptions& options, int trial, CameraTask& task) {
  const double sign = trial % 2 == 0 ? 1.0 : -1.0;
  task.intrinsics.fx *= 1.0 + sign * 0.01 * options.focal_error;
  task.intrinsics.fy *= 1.0 + sign * 0.01 * options.focal_error;
  task.intrinsics.cx += sign * options.centre_px;
  task.intrinsics.cy += sign * options.centre_px;
  if (!task.intrinsics.distortion.empty()) task.intrinsics.distortion[0] += sign * options.k1_error;
}

// Images that are not of the stops they stand for, or of a camera that was turned.
void spoil_images(const TrialOptions& options, CameraTask& task) {
  const std::size_t count = task.views.size();
  const std::vector<CameraView> views = task.views;
  for (std::size_t k = 0; k < count; ++k) {
    CameraView& view = task.views[k];
    if (options.alien > 0 &&
        k % static_cast<std::size_t>(options.alien) == static_cast<std::size_t>(options.alien) - 1) {
      view.grey = views[(k + count / 2) % count].grey;
      view.edges = nullptr;
    }
    if (options.moved_px == 0.0 || static_cast<double>(k) < options.moved_from * static_cast<double>(count)) continue;
    view.edges = nullptr;
    const auto width = static_cast<std::ptrdiff_t>(view.grey.width);
    const auto shift = static_cast<std::ptrdiff_t>(options.moved_px);
    for (auto row = view.grey.values.begin(); row != view.grey.values.end(); row += width) {
      std::copy(row + shift, row + width, row);
    }
  }
}

// One sensor of a result against the truth.
Trial compare(const std::string& base, const std::string& name, const SE3& T_base_sensor, const Matrix6d* covariance,
              Status status, const KnownRig& truth) {
  KnownRig result;
  result.base = base;
  result.sensors.push_back({name, status, T_base_sensor, {}});
  if (covariance != nullptr) result.sensors.back().covariance = *covariance;
  Trial trial;
  const Expected<Evaluation> evaluation = evaluate(result, truth);
  if (evaluation && !evaluation->sensors.empty()) trial.error = evaluation->sensors.front();
  trial.flagged = status != Status::good;
  return trial;
}

void tell(const std::string& session, int number, const Trial& trial, const CameraEstimate& e, const Verdict& verdict,
          bool reasons) {
  std::printf(
      "%s %d %s%s | f %+.3f%% (%.3f) k1 %+.4f (%.4f) c %+.2f (%.2f) %+.2f (%.2f) px trend %+.2f px | hold-out %.2f, "
      "halves %.1f mm %.3f deg, "
      "chi2 %.1f, runner-up %.2f, segments %zu, hold-out share %.2f, first and last %.1f mm %.3f deg chi2 %.0f gain "
      "%.2f\n",
      session.c_str(), number, trial_text(trial).c_str(),
      trial.is_right() == !trial.flagged ? "" : (trial.is_right() ? " FALSE ALARM" : " MISSED"),
      100.0 * e.focal_scale.value, 100.0 * e.focal_scale.sigma, e.k1_change.value, e.k1_change.sigma,
      e.cx_change_px.value, e.cx_change_px.sigma, e.cy_change_px.value, e.cy_change_px.sigma, e.radial_trend.value,
      e.hold_out, 1e3 * e.halves_m, to_deg(e.halves_rad), e.disagreement_chi2, e.runner_up_ratio, e.segments,
      e.hold_out_share.value_or(0.0), 1e3 * e.first_and_last.apart_m, to_deg(e.first_and_last.apart_rad),
      e.first_and_last.chi2, e.first_and_last.gain);
  if (reasons && !e.stops.empty()) {
    std::printf("    what stops show by more than chance, of what is expected:");
    for (const StopAgreement& stop : e.stops) {
      std::printf(" %d: %.1f of %.1f", stop.stop, stop.more_than_chance(), stop.expected);
    }
    std::printf("\n");
  }
  if (e.information && trial.error.compared) {
    const SE3 apart = e.pose.T_base_camera.inverse() * e.information->T_base_camera;
    std::printf("    information %.1f mm %.3f deg from the result\n", 1e3 * apart.t.norm(),
                to_deg(log_so3(apart.R).norm()));
  }
  for (std::size_t k = 0; reasons && k < verdict.reasons.size(); ++k)
    std::printf("    %s\n", verdict.reasons[k].c_str());
  std::fflush(stdout);
}

Expected<void> run_trial(const TrialOptions& options, int number, const TrialSession& session,
                         const RunContext& context, Camera& camera) {
  // The same starts for every session, its cameras apart.
  Random random(options.seed + static_cast<std::uint64_t>(number), static_cast<std::uint64_t>(camera.task.sensor));
  const SE3 off{exp_so3(to_rad(options.start_deg) * random_direction(random)),
                1e-3 * options.start_mm * random_direction(random)};
  CameraTask task = camera.task;
  if (!options.no_guess) task.guess_T_base_camera = camera.T_base_camera_true * off;
  spoil(options, number, task);
  spoil_images(options, task);
  CameraCalibrationOptions how;
  how.refine_intrinsics = options.refine;
  if (options.stay) {
    how.guess_sigma_m = 0.01;
    how.guess_sigma_rad = to_rad(0.3);
  }
  Expected<CameraEstimate> estimate = calibrate_camera(session.scene, task, how, context);
  if (!estimate) return estimate.error();
  const Verdict verdict = judge_camera(*estimate, task.name, {}, options.refine);
  Trial trial;
  trial.error.name = task.name;
  trial.flagged = true;
  if (estimate->found && verdict.status != Status::failed) {
    trial = compare(session.truth.base, task.name, estimate->pose.T_base_camera, &estimate->pose.covariance,
                    verdict.status, session.truth);
  }
  trial.wall_s = estimate->wall_s;
  tell(session.name, number, trial, *estimate, verdict, options.reasons);
  camera.trials.push_back(trial);
  camera.estimates.push_back(std::move(*estimate));
  return {};
}

// The truth takes the guess' colour: where the two part is what went wrong.
Expected<void> draw_worst(const std::string& folder, const TrialSession& session, const Camera& camera) {
  const auto worst = worst_trial(camera.trials);
  if (!worst) return {};
  CameraTask task = camera.task;
  task.guess_T_base_camera = camera.T_base_camera_true;
  for (const Overlay& overlay : draw_overlays(session.scene, task, camera.estimates[*worst])) {
    const std::string kind = overlay.kind == OverlayKind::map ? "_map" : "";
    const std::string path =
        folder + "/" + session.name + "_" + overlay.sensor + "_" + std::to_string(overlay.stop) + kind + ".jpg";
    Expected<OutputFile> file = OutputFile::create(path);
    if (!file) return file.error();
    file->write(ByteView(overlay.jpeg));
    if (Expected<void> closed = file->close(); !closed) return closed;
  }
  return {};
}

// Every pair of cameras of one trial, by way of the base.
void compare_cameras(const TrialSession& session, std::vector<Trial>& pairs) {
  for (std::size_t a = 0; a < session.cameras.size(); ++a) {
    for (std::size_t b = a + 1; b < session.cameras.size(); ++b) {
      const Camera& left = session.cameras[a];
      const Camera& right = session.cameras[b];
      for (std::size_t k = 0; k < left.trials.size(); ++k) {
        if (!left.trials[k].error.compared || !right.trials[k].error.compared) continue;
        const SE3 T = left.estimates[k].pose.T_base_camera.inverse() * right.estimates[k].pose.T_base_camera;
        const Status status = std::max(left.trials[k].error.status, right.trials[k].error.status);
        pairs.push_back(compare(left.task.name, right.task.name, T, nullptr, status, session.truth));
      }
    }
  }
}

Expected<void> run(const TrialOptions& options) {
  SilentReporter silent;
  const RunContext context{silent};
  std::vector<Trial> all;
  std::vector<Trial> pairs;
  for (const std::string& path : options.sessions) {
    Expected<TrialSession> session = open_trial_session(path, options, context);
    if (!session) return session.error();
    std::printf("%s: %zu LiDAR edge points, %zu map samples\n", session->name.c_str(), session->scene.edges.size(),
                session->scene.samples.size());
    for (Camera& camera : session->cameras) {
      for (int k = 0; k < options.trials; ++k) {
        if (Expected<void> done = run_trial(options, k, *session, context, camera); !done) return done;
      }
      std::printf("%s", summary_text(session->name + " " + camera.task.name, camera.trials).c_str());
      all.insert(all.end(), camera.trials.begin(), camera.trials.end());
      if (options.overlays.empty()) continue;
      if (Expected<void> drawn = draw_worst(options.overlays, *session, camera); !drawn) return drawn;
    }
    compare_cameras(*session, pairs);
  }
  if (!pairs.empty()) std::printf("%s", summary_text("camera to camera", pairs).c_str());
  std::printf("%s", summary_text("all", all).c_str());
  return {};
}

}  // namespace
}  // namespace rigcal

int main(int count, char** arguments) {
  rigcal::TrialOptions options;
  CLI::App app("Find the cameras of simulated sessions from many starts, and count what is right");
  app.add_option("SESSION", options.sessions, "Sessions with a ground_truth.yaml")->required();
  app.add_option("--trials", options.trials, "Starts a camera");
  app.add_option("--seed", options.seed, "Of the starts");
  app.add_option("--camera", options.camera, "Only this one");
  app.add_option("--start-deg", options.start_deg, "Rotation by which each start is off");
  app.add_option("--start-mm", options.start_mm, "Shift by which each start is off");
  app.add_flag("--no-guess", options.no_guess, "Without any start: one trial a camera says it all");
  app.add_option("--focal-error", options.focal_error,
                 "Percent by which the focal lengths are wrong, up and down in turn");
  app.add_option("--centre-px", options.centre_px,
                 "By how many pixels the principal point is wrong both ways, right and down and left and up in turn");
  app.add_option("--k1-error", options.k1_error, "By how much k1 is wrong, up and down in turn");
  app.add_option("--alien", options.alien, "Every so manieth image is that of another stop")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--moved-px", options.moved_px, "The camera turns to the right by so many pixels")
      ->check(CLI::Range(0.0, 200.0));
  app.add_option("--moved-from", options.moved_from, "From this share of its images on");
  app.add_flag("--stay", options.stay,
               "Tell the program that the start is nearly right, so that it stays in that minimum");
  app.add_flag("--refine-intrinsics", options.refine, "As calibrate has it");
  app.add_flag("--reasons", options.reasons, "Print the reasons of every verdict");
  app.add_option("--overlays", options.overlays,
                 "Folder for pictures of the worst trial of each camera, the truth in orange");
  app.footer("Example:\n  camera_trials courtyard-1 courtyard-2 --trials 10 --focal-error 1");
  CLI11_PARSE(app, count, arguments);
  const rigcal::Expected<void> done = rigcal::run(options);
  if (done) return 0;
  std::fprintf(stderr, "camera_trials: %s\n", done.error().message().c_str());
  return 3;
}
