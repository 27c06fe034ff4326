#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "apps/calibration_text.h"
#include "apps/command.h"
#include "apps/input_digester.h"
#include "apps/recording.h"
#include "apps/tolerance.h"
#include "core/base/text.h"
#include "core/io/extrinsics_file.h"
#include "core/pipeline/stage_clock.h"
#include "core/report/result_folder.h"

namespace rigcal {
namespace {

struct CalibrateOptions {
  std::string input;
  std::string out;
  std::string rig;
  std::string method = "targetless";
  std::string stages = "joint";
  std::string initial;
  std::string require = "10mm,0.1deg";
  std::vector<double> pose_prior{0.05, 2.0};
  bool full_map = false;
};

// --initial is read before the recording is, which takes longer; nothing where it is not given.
Expected<std::optional<ExtrinsicsFile>> rough_extrinsics(const std::string& path) {
  if (path.empty()) return std::optional<ExtrinsicsFile>();
  Expected<ExtrinsicsFile> loaded = load_extrinsics(path);
  if (!loaded) return loaded.error();
  return std::optional<ExtrinsicsFile>(std::move(*loaded));
}

// The guess of each LiDAR: from --initial where given, else from the rig file.
Expected<std::vector<std::optional<SE3>>> guesses(const Recording& recording,
                                                  const std::optional<ExtrinsicsFile>& initial,
                                                  const std::string& path) {
  std::vector<std::optional<SE3>> out;
  if (initial && initial->base != recording.rig.base_sensor().name) {
    return input_error("its base is " + initial->base + ", the rig's is " + recording.rig.base_sensor().name, path,
                       "give extrinsics with the rig's base");
  }
  for (const int sensor : recording.lidar.lidar_sensors) {
    const Sensor& s = recording.rig.sensors[static_cast<std::size_t>(sensor)];
    if (sensor == recording.rig.base) {
      out.emplace_back(SE3{});
    } else if (initial && initial->T_base_sensor.count(s.name) > 0) {
      out.emplace_back(initial->T_base_sensor.at(s.name));
    } else {
      out.push_back(s.initial_T_base_sensor);
    }
  }
  return out;
}

LastStage last_stage(const std::string& name) {
  if (name == "poses") return LastStage::poses;
  return name == "extrinsics" ? LastStage::extrinsics : LastStage::joint;
}

// Only LiDARs are solved for: whoever recorded images should know what became of them.
void tell_of_images(const std::string& input, const Rig& rig, Reporter& reporter) {
  std::error_code error;
  std::string left_out;
  for (const Sensor& sensor : rig.sensors) {
    const bool any = std::filesystem::is_directory(std::filesystem::path(input) / "images" / sensor.name, error) ||
                     std::filesystem::is_directory(std::filesystem::path(input) / "image" / sensor.name, error);
    if (!sensor.is_lidar() && any) left_out.append(left_out.empty() ? "" : ", ").append(sensor.name);
  }
  if (!left_out.empty()) reporter.warn("the images of " + left_out + " are not used: only LiDARs are calibrated");
}

// What the report tells of the run, so that it can be repeated.
std::vector<std::pair<std::string, std::string>> settings_of(const CalibrateOptions& options) {
  const std::string prior = number_text(options.pose_prior[0]) + "," + number_text(options.pose_prior[1]);
  return {{"INPUT", options.input},
          {"--rig", options.rig.empty() ? "the session's own" : options.rig},
          {"--method", options.method},
          {"--stages", options.stages},
          {"--initial", options.initial.empty() ? "the rig file's" : options.initial},
          {"--require", options.require},
          {"--pose-prior", prior},
          {"--full-map", options.full_map ? "yes" : "no"}};
}

Expected<ExitCode> run_calibrate(const CalibrateOptions& options, CommandContext& context) {
  if (const auto target = check_result_target(options.out); !target) return target.error();
  const Expected<Tolerance> require = parse_tolerance(options.require);
  if (!require) return require.error();
  const auto initial = rough_extrinsics(options.initial);
  if (!initial) return initial.error();
  InputDigester digester(options.rig.empty() ? std::vector{options.input} : std::vector{options.input, options.rig});
  CellOptions cells;
  cells.keep_thinned = true;
  StageClock clock;
  StageReport& reading = clock.begin("reading");
  const Expected<Recording> recording = read_recording(options.input, options.rig, cells, context.run_context());
  if (!recording) return recording.error();
  reading.counts = {{"points", static_cast<double>(recording->points)},
                    {"stops", static_cast<double>(recording->lidar.stops.size())}};
  tell_of_images(options.input, recording->rig, context.reporter);
  const auto guess = guesses(*recording, *initial, options.initial);
  if (!guess) return guess.error();

  LidarCalibrationOptions calibration;
  calibration.require = {require->translation_m, require->rotation_rad};
  calibration.last_stage = last_stage(options.stages);
  calibration.pose_prior_m = options.pose_prior[0];
  calibration.pose_prior_rad = to_rad(options.pose_prior[1]);
  if (options.full_map) calibration.map_size_m = 0.0;
  std::vector<StageReport> stages = clock.take();
  Expected<CalibrationResult> result =
      calibrate_lidars(recording->rig, recording->lidar, *guess, calibration, context.run_context());
  if (!result) return result.error();
  result->stages.insert(result->stages.begin(), stages.begin(), stages.end());
  result->warnings = context.reporter.warnings();
  result->packets = recording->packets;
  result->clocks = recording->clocks;
  result->settings = settings_of(options);
  result->inputs = digester.take();
  if (context.stop.stop_requested()) {
    return Error{ErrorKind::cancelled, "stopped before the end, nothing was written", {}, {}};
  }
  if (const auto written = write_result_folder(*result, options.out); !written) return written.error();
  if (context.json) {
    CommandContext::print(calibration_json(*result, options.out));
  } else if (!context.quiet) {
    CommandContext::print(calibration_text(*result, options.out));
  }
  return exit_code_of(result->status);
}

}  // namespace

void add_calibrate_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = app.add_subcommand("calibrate", "Find the extrinsics of a rig from a recording: the main job");
  command->add_option("INPUT", options->input, "A packet dump, an .lvx file, a ROS 1 bag, a session or a patch folder")
      ->required();
  command->add_option("--out", options->out, "The result folder; an older result there is replaced as a whole")
      ->required()
      ->option_text("RESULT");
  command->add_option("--rig", options->rig, "The rig file (a session brings its own)")->option_text("RIG");
  command->add_option("--method", options->method, "targetless (default)")
      ->check(CLI::IsMember({"targetless"}))
      ->option_text("METHOD");
  command->add_option("--stages", options->stages, "Stop after poses, extrinsics or joint (default)")
      ->check(CLI::IsMember({"poses", "extrinsics", "joint"}))
      ->option_text("STAGE");
  command
      ->add_option("--initial", options->initial,
                   "Rough extrinsics: an extrinsics.yaml, a ground_truth.yaml or a rig file (default: the rig's)")
      ->option_text("FILE");
  command->add_option("--require", options->require, "What good means: 95 % bounds (default 10mm,0.1deg)")
      ->check(CLI::Validator(check_tolerance, ""))
      ->option_text("MM,DEG");
  command
      ->add_option("--pose-prior", options->pose_prior,
                   "How far a given trajectory may be off: metres, degrees (default 0.05,2)")
      ->delimiter(',')
      ->expected(2)
      ->check(CLI::PositiveNumber)
      ->option_text("M,DEG");
  command->add_flag("--full-map", options->full_map, "map.ply with all points kept, not one for each 2 cm");
  command->footer("Example:\n  rigcal calibrate run.pcap --rig rig.yaml --out result");
  command->callback(
      [options, &context] { context.run = [options, &context] { return run_calibrate(*options, context); }; });
}

}  // namespace rigcal
