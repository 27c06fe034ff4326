#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "apps/calibration/calibration_run.h"
#include "apps/calibration/estimate_text.h"
#include "apps/calibration/input_digester.h"
#include "apps/commands/calibrate_options.h"
#include "apps/commands/calibration_text.h"
#include "apps/commands/command.h"
#include "apps/commands/option_checks.h"
#include "apps/common/kept_memory.h"
#include "apps/common/tolerance.h"
#include "apps/recording/recording.h"
#include "apps/recording/rig_lidars.h"
#include "core/base/text.h"
#include "core/io/extrinsics_file.h"
#include "core/pipeline/board_calibration.h"
#include "core/pipeline/corner_calibration.h"
#include "core/pipeline/incremental_calibration.h"
#include "core/pipeline/stage_clock.h"
#include "core/report/result_folder.h"

namespace rigcal {
namespace {

constexpr double board_reach_m = 12.0;

// --initial is read before the recording is, which takes longer; nothing where it is not given.
Expected<std::optional<ExtrinsicsFile>> rough_extrinsics(const std::string& path) {
  if (path.empty() || path == no_guess) return std::optional<ExtrinsicsFile>();
  Expected<ExtrinsicsFile> loaded = load_extrinsics(path);
  if (!loaded) return loaded.error();
  if (loaded->T_base_sensor.empty()) return input_error("has no transform", path, "give a result that has one");
  return std::optional<ExtrinsicsFile>(std::move(*loaded));
}

// The guess of a sensor: from --initial where that has it, else from the rig file.
std::optional<SE3> guess_of(const Sensor& sensor, const std::optional<ExtrinsicsFile>& initial) {
  if (initial && initial->T_base_sensor.count(sensor.name) > 0) return initial->T_base_sensor.at(sensor.name);
  return sensor.initial_T_base_sensor;
}

// Of all sensors but the base, whose frame is the rig's.
void forget_initial_extrinsics(Rig& rig) {
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    if (static_cast<int>(i) != rig.base) rig.sensors[i].initial_T_base_sensor.reset();
  }
}

// Of a larger rig, or misspelt.
void warn_of_unused(const Rig& rig, const ExtrinsicsFile& initial, const std::string& path, Reporter& reporter) {
  for (const std::string& name : initial.names) {
    if (rig.find(name) < 0) reporter.warn(path + ": " + name + " is no sensor of the rig: its extrinsics are not used");
  }
}

std::vector<std::optional<SE3>> lidar_guesses(const Recording& recording,
                                              const std::optional<ExtrinsicsFile>& initial) {
  std::vector<std::optional<SE3>> out;
  for (const int sensor : recording.lidar.lidar_sensors) {
    out.push_back(sensor == recording.rig.base
                      ? SE3{}
                      : guess_of(recording.rig.sensors[static_cast<std::size_t>(sensor)], initial));
  }
  return out;
}

std::vector<std::optional<SE3>> sensor_guesses(const Rig& rig, const std::optional<ExtrinsicsFile>& initial) {
  std::vector<std::optional<SE3>> out;
  for (const Sensor& sensor : rig.sensors) out.push_back(guess_of(sensor, initial));
  out[static_cast<std::size_t>(rig.base)] = SE3{};
  return out;
}

LastStage last_stage(const std::string& name) {
  if (name == "poses") return LastStage::poses;
  return name == "extrinsics" ? LastStage::extrinsics : LastStage::joint;
}

RigCalibrationOptions calibration_options(const CalibrateOptions& options, const Tolerance& require) {
  RigCalibrationOptions out;
  out.lidars.require = {require.translation_m, require.rotation_rad};
  out.lidars.last_stage = last_stage(options.stages);
  out.lidars.pose_prior_m = options.pose_prior[0];
  out.lidars.pose_prior_rad = to_rad(options.pose_prior[1]);
  if (options.full_map) out.lidars.map_size_m = 0.0;
  if (options.stages == "cameras") {
    out.cameras->refine_intrinsics = options.refine_intrinsics;
  } else {
    out.cameras.reset();
  }
  return out;
}

// As `capture --calibrate` does while the table turns: a line after each stop, then the result of all of them.
Expected<CalibrationResult> calibrate_stop_by_stop(const Recording& recording,
                                                   const std::vector<std::optional<SE3>>& guesses,
                                                   const CalibrateOptions& options, const Tolerance& require,
                                                   CommandContext& context, std::vector<StopEstimate>& estimates) {
  const RigCalibrationOptions chosen = calibration_options(options, require);
  IncrementalCalibration calibration(recording.rig, recording.lidar.lidar_sensors, guesses,
                                     {chosen.lidars, chosen.lidars.require});
  SilentReporter silent;
  for (CalibrationStop& stop : stops_of(recording.lidar)) {
    calibration.add_stop(std::move(stop));
    Expected<StopEstimate> estimate = calibration.estimate({silent, context.stop});
    if (!estimate) return estimate.error();
    if (!context.json && !context.quiet) {
      context.reporter.clear();
      CommandContext::print(estimate_line(*estimate) + "\n");
      for (const std::string& remark : estimate_remarks(*estimate)) CommandContext::print("  - " + remark + "\n");
    }
    estimates.push_back(std::move(*estimate));
  }
  return calibration.finish(recording.cameras, chosen.cameras, context.run_context());
}

Expected<CalibrationResult> calibrate(const Recording& recording, const std::optional<ExtrinsicsFile>& initial,
                                      const CalibrateOptions& options, const Tolerance& require,
                                      CommandContext& command, std::vector<StopEstimate>& estimates) {
  if (options.method == "checkerboard") {
    const BoardCalibrationOptions board{
        {require.translation_m, require.rotation_rad}, options.refine_intrinsics, options.seed};
    return calibrate_by_boards(recording.rig, {recording.lidar.stops, recording.near_points, recording.cameras},
                               sensor_guesses(recording.rig, initial), board, command.run_context());
  }
  const std::vector<std::optional<SE3>> guesses = lidar_guesses(recording, initial);
  if (options.incremental) {
    return calibrate_stop_by_stop(recording, guesses, options, require, command, estimates);
  }
  const RunContext context = command.run_context();
  if (options.method == "planes") {
    CornerCalibrationOptions corner;
    corner.require = {require.translation_m, require.rotation_rad};
    if (options.full_map) corner.map_size_m = 0.0;
    return calibrate_by_planes(recording.rig, recording.lidar, guesses, corner, context);
  }
  return calibrate_rig(recording.rig, recording.lidar, recording.cameras, guesses,
                       calibration_options(options, require), context);
}

// What the rig lacks for the method is told before any point is read. Gives what --rig holds, where it is given.
Expected<std::optional<RigFile>> check_rig(const CalibrateOptions& options) {
  namespace fs = std::filesystem;
  std::error_code error;
  const std::string own = (fs::path(options.input) / "rig.yaml").string();
  const std::string file = options.rig.empty() && fs::exists(own, error) ? own : options.rig;
  std::optional<RigFile> given;
  if (file.empty()) return given;  // what that means is told by whoever reads the recording
  Expected<RigFile> loaded = load_rig_file(file);
  if (!loaded) return loaded.error();
  const Rig& rig = loaded->rig;
  if (options.method == "checkerboard") {
    const Expected<void> fit = check_board(rig);
    if (!fit) return Error{fit.error().kind, fit.error().what, file, fit.error().mend};
  }
  if (options.method == "checkerboard" || !lidar_sensors(rig).empty()) {
    if (!options.rig.empty()) given = *std::move(loaded);
    return given;
  }
  return input_error("the rig has no LiDAR, and --method " + options.method + " needs one as base", file,
                     "add it; cameras alone are found by --method checkerboard");
}

// What was asked for and changes nothing with this recording.
void warn_of_useless_options(const CalibrateOptions& options, const Recording& recording, Reporter& reporter) {
  const bool has_camera = std::any_of(recording.rig.sensors.begin(), recording.rig.sensors.end(),
                                      [](const Sensor& sensor) { return !sensor.is_lidar(); });
  if (!has_camera && !options.images.empty()) reporter.warn("--images is of no use: the rig has no camera");
  if (!has_camera && options.refine_intrinsics)
    reporter.warn("--refine-intrinsics is of no use: the rig has no camera");
  if (!recording.lidar.trajectory_is_prior && options.pose_prior != CalibrateOptions{}.pose_prior)
    reporter.warn("--pose-prior is of no use: the recording has no trajectory");
}

Expected<ExitCode> calibrate_and_write(const CalibrateOptions& options, CommandContext& context) {
  keep_freed_memory();
  if (const auto target = check_result_target(options.out); !target) return target.error();
  const Expected<Tolerance> require = parse_tolerance(options.require);
  if (!require) return require.error();
  auto known_rig = check_rig(options);
  if (!known_rig) return known_rig.error();
  auto initial = rough_extrinsics(options.initial);
  if (!initial) return initial.error();
  InputDigester digester(inputs_of(options));
  CellOptions cells;
  cells.keep_thinned = true;
  // Boards stand near; nothing else of the points is needed whole.
  const double keep_within_m = options.method == "checkerboard" ? board_reach_m : 0.0;
  StageClock clock;
  StageReport& reading = clock.begin("reading");
  Expected<Recording> recording = read_recording(
      {options.input, options.rig, options.images, keep_within_m, *std::move(known_rig)}, cells, context.run_context());
  if (!recording) return recording.error();
  reading.counts = {{"points", static_cast<double>(recording->points)},
                    {"stops", static_cast<double>(recording->lidar.stops.size())}};
  if (*initial) {
    if (const auto right = change_base(**initial, recording->rig.base_sensor().name); !right)
      return Error{right.error().kind, right.error().what, options.initial, right.error().mend};
  }
  warn_of_useless_options(options, *recording, context.reporter);
  if (*initial) warn_of_unused(recording->rig, **initial, options.initial, context.reporter);
  if (options.initial == no_guess) forget_initial_extrinsics(recording->rig);
  if (!options.initial.empty()) tell_turns_by(lidar_guesses(*recording, *initial), *recording);
  for (CameraRecording& camera : recording->cameras) {
    camera.guess_T_base_camera = guess_of(recording->rig.sensors[static_cast<std::size_t>(camera.sensor)], *initial);
  }
  std::vector<StageReport> stages = clock.take();
  std::vector<StopEstimate> estimates;
  Expected<CalibrationResult> result = calibrate(*recording, *initial, options, *require, context, estimates);
  if (!result) return result.error();
  CalibrationRun run{std::move(stages), context.reporter.warnings(), settings_of(options), digester.take()};
  if (context.stop.stop_requested()) return cancelled_error();
  if (const auto written = write_calibration(*recording, std::move(run), options.out, *result); !written) {
    return written.error();
  }
  if (context.json) {
    CommandContext::print(calibration_json(*result, options.out, estimates));
  } else if (!context.quiet) {
    CommandContext::print(calibration_text(*result, options.out));
  }
  return exit_code_of(result->status);
}

Expected<ExitCode> run_calibrate(const CalibrateOptions& options, CommandContext& context) {
  Expected<ExitCode> code = calibrate_and_write(options, context);
  if (!code && code.error().kind == ErrorKind::cancelled)
    return cancelled_error("stopped before the end, nothing was written");
  return code;
}

}  // namespace

void add_calibrate_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = app.add_subcommand("calibrate", "Find the extrinsics of a rig from a recording: the main job");
  command->add_option("INPUT", options->input, "A packet dump, an .lvx file, a ROS 1 bag, a session or a patch folder")
      ->required();
  command->add_option("--out", options->out, "The result folder; an older result there is replaced as a whole")
      ->required()
      ->check(named_path())
      ->option_text("RESULT");
  add_calibration_options(*command, *options);
  command
      ->add_option("--images", options->images,
                   "The cameras' images where they do not lie with the recording: DIR/<camera>/ as in a session")
      ->option_text("DIR");
  command->add_flag("--incremental", options->incremental,
                    "Also solve after every stop, and say what is known by then and which turn would help most");
  command->footer("Example:\n  rigcal calibrate run.pcap --rig rig.yaml --out result");
  command->callback([options, command, &context] {
    check_calibration_options(*options, *command);
    context.run = [options, &context] { return run_calibrate(*options, context); };
  });
}

}  // namespace rigcal
