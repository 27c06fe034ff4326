#include "apps/commands/calibrate_options.h"

#include <CLI/CLI.hpp>

#include "apps/commands/option_checks.h"
#include "apps/common/tolerance.h"
#include "core/base/text.h"
#include "core/io/extrinsics_file.h"

namespace rigcal {
namespace {

std::string prior_text(const CalibrateOptions& options) {
  return number_text(options.pose_prior[0]) + "," + number_text(options.pose_prior[1]);
}

}  // namespace

void add_calibration_options(CLI::App& command, CalibrateOptions& options) {
  command.add_option("--rig", options.rig, "The rig file (a session brings its own, a patch folder may)")
      ->option_text("RIG");
  command
      .add_option("--method", options.method,
                  "targetless (default): all stops together; planes: LiDARs from the planes of one still moment; "
                  "checkerboard: LiDARs and cameras by a board shown in several poses")
      ->check(CLI::IsMember({"targetless", "planes", "checkerboard"}))
      ->option_text("METHOD");
  command
      .add_option("--stages", options.stages, "Stop after poses, extrinsics, joint (all LiDARs) or cameras (default)")
      ->check(CLI::IsMember({"poses", "extrinsics", "joint", "cameras"}))
      ->option_text("STAGE");
  command
      .add_option("--initial", options.initial,
                  "Rough extrinsics: a result, a ground_truth.yaml or a rig file (default: the rig's); none: "
                  "LiDARs from the turn of the rig alone")
      ->option_text("FILE|none");
  command.add_flag("--refine-intrinsics", options.refine_intrinsics,
                   "Find each camera's intrinsics, too, starting from the rig file's (with a checkerboard from none)");
  command.add_option("--require", options.require, "What good means: 95 % bounds (default 10mm,0.1deg)")
      ->check(CLI::Validator(check_tolerance, ""))
      ->option_text("MM,DEG");
  command
      .add_option("--pose-prior", options.pose_prior,
                  "How far a given trajectory may be off: metres, degrees (default 0.05,2)")
      ->delimiter(',')
      ->expected(2)
      ->check(number_range(1e-6, 1e6))
      ->option_text("M,DEG");
  command
      .add_option(
          "--seed", options.seed,
          "Of the draws by which --method checkerboard finds boards in clouds with rings; nothing else is drawn "
          "(default 1)")
      ->check(seed_range())
      ->option_text("N");
  command.add_flag("--full-map", options.full_map,
                   "map.ply with a point for each 2 cm of every patch, not of all together");
}

void check_calibration_options(const CalibrateOptions& options, const CLI::App& command) {
  const auto refuse = [&](const std::vector<const char*>& names, const std::string& with) {
    for (const char* name : names) {
      const CLI::Option* option = command.get_option_no_throw(name);
      if (option != nullptr && option->count() > 0) throw CLI::ValidationError(name, "is of no use with " + with);
    }
  };
  std::vector<const char*> useless;
  if (options.method == "planes")
    useless = {"--stages", "--images", "--refine-intrinsics", "--pose-prior", "--incremental"};
  if (options.method == "checkerboard") useless = {"--stages", "--pose-prior", "--full-map", "--incremental"};
  refuse(useless, "--method " + options.method);
  if (options.stages != "cameras") refuse({"--images", "--refine-intrinsics"}, "--stages " + options.stages);
}

std::vector<std::string> arguments_of(const CalibrateOptions& options) {
  const CalibrateOptions usual;
  std::vector<std::string> out;
  const auto give = [&](const std::string& name, const std::string& value, const std::string& usual_value) {
    if (value != usual_value) out.push_back(name + "=" + value);
  };
  give("--rig", options.rig, usual.rig);
  give("--method", options.method, usual.method);
  give("--stages", options.stages, usual.stages);
  give("--initial", options.initial, usual.initial);
  give("--require", options.require, usual.require);
  give("--pose-prior", prior_text(options), prior_text(usual));
  give("--seed", std::to_string(options.seed), std::to_string(usual.seed));
  if (options.refine_intrinsics) out.emplace_back("--refine-intrinsics");
  if (options.full_map) out.emplace_back("--full-map");
  return out;
}

std::vector<std::pair<std::string, std::string>> settings_of(const CalibrateOptions& options) {
  return {{"INPUT", options.input},
          {"--rig", options.rig.empty() ? "INPUT's own" : options.rig},
          {"--method", options.method},
          {"--stages", options.stages},
          {"--initial", options.initial.empty() ? "the rig file's" : options.initial},
          {"--images", options.images.empty() ? "those of INPUT" : options.images},
          {"--refine-intrinsics", options.refine_intrinsics ? "yes" : "no"},
          {"--require", options.require},
          {"--pose-prior", prior_text(options)},
          {"--seed", std::to_string(options.seed)},
          {"--full-map", options.full_map ? "yes" : "no"}};
}

std::vector<std::string> inputs_of(const CalibrateOptions& options) {
  std::vector<std::string> out{options.input};
  for (const std::string& path : {options.rig, options.images}) {
    if (!path.empty()) out.push_back(path);
  }
  if (!options.initial.empty() && options.initial != no_guess) {
    const Expected<std::string> file = extrinsics_path(options.initial);
    out.push_back(file ? *file : options.initial);
  }
  return out;
}

}  // namespace rigcal
