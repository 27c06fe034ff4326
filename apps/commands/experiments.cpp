#include "apps/commands/experiments.h"

#include "apps/commands/known_files.h"
#include "apps/common/kept_memory.h"
#include "apps/experiment/base_experiment.h"
#include "apps/experiment/board_experiment_text.h"
#include "apps/experiment/bound/bound_experiment.h"
#include "apps/experiment/parts.h"
#include "apps/experiment/planes_experiment_text.h"
#include "apps/experiment/speed/experiment.h"
#include "apps/experiment/targetless/experiment.h"
#include "core/base/parallel.h"

namespace rigcal {
namespace {

using Findings = ExperimentFindings;

Expected<Findings> run_targetless(const ExperimentOptions& options, const RunContext& context) {
  const auto experiment = targetless::run_parts({options.parts, options.trials, options.seed, options.points}, context);
  if (!experiment) return experiment.error();
  return Findings{targetless::experiment_text(*experiment), targetless::experiment_json(*experiment),
                  targetless::experiment_files(*experiment)};
}

Expected<Findings> run_planes(const ExperimentOptions& options, const RunContext& context) {
  PlanesExperiment experiment;
  experiment.trials = options.trials.value_or(100);
  Expected<std::vector<CornerRow>> table = repeat_table(experiment.trials, options.seed, context);
  if (!table) return table.error();
  experiment.table = std::move(*table);
  const Expected<MountingFigures> mountings = try_mountings(options.mountings, options.seed, context);
  if (!mountings) return mountings.error();
  experiment.mountings = *mountings;
  for (const bool with_guess : {false, true}) {
    const auto figures = try_right_angles(options.mountings, with_guess, options.seed, context);
    if (!figures) return figures.error();
    (with_guess ? experiment.right_angles_guessed : experiment.right_angles) = *figures;
  }
  Expected<VehicleExperiment> vehicle = drive_vehicle(options.places, options.seed, context);
  if (!vehicle) return vehicle.error();
  experiment.vehicle = std::move(*vehicle);
  const VehicleMoment& moment = experiment.vehicle.moment;
  return Findings{planes_experiment_text(experiment),
                  planes_experiment_json(experiment),
                  {{"before.svg",
                    moment_svg(moment, moment.T_guess, "Two LiDARs of a vehicle from above, by a guess without turns")},
                   {"after.svg", moment_svg(moment, moment.T_found, "The same, as calibrated")}}};
}

Expected<Findings> run_checkerboard(const ExperimentOptions& options, const RunContext& context) {
  BoardExperiment experiment;
  const bool with_curves = is_wanted("curves", options.parts);
  if (with_curves || is_wanted("pairs", options.parts)) {
    BoardDrawOptions draws = options.boards;
    draws.seed = options.seed;
    draws.asked_only = !with_curves;
    Expected<std::vector<BoardRow>> rows = draw_boards(draws, context);
    if (!rows) return rows.error();
    experiment.rows = std::move(*rows);
  }
  if (is_wanted("detection", options.parts)) {
    Expected<std::vector<DetectionRow>> rows = detect_boards(options.shown, options.seed, context);
    if (!rows) return rows.error();
    experiment.detection = std::move(*rows);
  }
  if (is_wanted("livox", options.parts)) {
    LivoxBoardOptions livox;
    livox.rigs = options.rigs.value_or(livox.rigs);
    livox.seed = options.seed;
    Expected<std::vector<LivoxRow>> rows = try_livox_boards(livox, context);
    if (!rows) return rows.error();
    experiment.livox = std::move(*rows);
  }
  return Findings{board_experiment_text(experiment), board_experiment_json(experiment),
                  board_experiment_pictures(experiment.rows)};
}

Expected<Findings> run_sigma(const ExperimentOptions& options, const RunContext& context) {
  SigmaExperimentOptions sigma;
  sigma.seed = options.seed;
  sigma.rigs = options.rigs.value_or(sigma.rigs);
  const Expected<std::vector<SigmaRow>> rows = try_sigmas(sigma, context);
  if (!rows) return rows.error();
  return Findings{sigma_experiment_text(*rows), sigma_experiment_json(*rows), {{"nees.svg", nees_svg(*rows)}}};
}

Expected<Findings> run_bound(const ExperimentOptions& options, const RunContext& context) {
  bound::BoundExperimentOptions chosen;
  chosen.seed = options.seed;
  chosen.rigs = options.rigs.value_or(chosen.rigs);
  chosen.points = options.points.value_or(chosen.points);
  const Expected<bound::BoundExperiment> experiment = bound::try_bounds(chosen, context);
  if (!experiment) return experiment.error();
  return Findings{bound::bound_experiment_text(*experiment), bound::bound_experiment_json(*experiment)};
}

Expected<Findings> run_start(const ExperimentOptions& options, const RunContext& context) {
  StartExperimentOptions start = options.start;
  start.seed = options.seed;
  start.rigs = options.rigs.value_or(start.rigs);
  start.points = options.points.value_or(start.points);
  const Expected<std::vector<StartRow>> rows = try_starts(start, context);
  if (!rows) return rows.error();
  return Findings{start_experiment_text(*rows), start_experiment_json(*rows)};
}

Expected<Findings> run_base(const ExperimentOptions& options, const RunContext& context) {
  BaseExperimentOptions base;
  base.seed = options.seed;
  base.points = options.points.value_or(base.points);
  base.with_guess = !options.no_guess;
  base.with_gyro = !options.no_gyro;
  base.rigs = options.rigs.value_or(base.rigs);
  const Expected<std::vector<BaseRow>> rows = try_bases(base, context);
  if (!rows) return rows.error();
  return Findings{base_experiment_text(*rows), base_experiment_json(*rows)};
}

Expected<Findings> run_speed(const ExperimentOptions& options, const RunContext& context) {
  keep_freed_memory();  // as calibrate
  speed::ExperimentOptions what{options.parts, options.scale, options.seed, {}, {}};
  what.programs.rig = rig_file("turntable");
  what.programs.scratch = options.scratch;
  what.programs.threads = thread_count();
  const auto experiment = speed::run_parts(what, context);
  if (!experiment) return experiment.error();
  return Findings{speed::experiment_text(*experiment), speed::experiment_json(*experiment),
                  speed::experiment_files(*experiment)};
}

}  // namespace

const std::vector<Experiment>& experiments() {
  static const std::vector<Experiment> all{
      {"targetless",
       "the main method, beside ICP and others",
       {"--trials", "--part", "--points", "--out"},
       targetless::part_names(),
       targetless::experiment_file_names(),
       run_targetless},
      {"planes",
       "LiDARs from the planes of a corner",
       {"--trials", "--mountings", "--places", "--out"},
       {},
       {"before.svg", "after.svg"},
       run_planes},
      {"checkerboard",
       "LiDARs and cameras by a board",
       {"--draws", "--sets", "--boards", "--part", "--rigs", "--out"},
       {"pairs", "curves", "detection", "livox"},
       board_experiment_files(),
       run_checkerboard},
      {"sigma", "whether errors are as large as sigma says", {"--rigs", "--out"}, {}, {"nees.svg"}, run_sigma},
      {"bound", "how far errors are above what the noise allows", {"--rigs", "--points", "--out"}, {}, {}, run_bound},
      {"start",
       "how many random rigs are found without a guess",
       {"--rigs", "--points", "--case", "--basin"},
       {},
       {},
       run_start},
      {"base",
       "whether the choice of the base changes a result",
       {"--rigs", "--points", "--no-guess", "--no-gyro"},
       {},
       {},
       run_base},
      {"speed",
       "what each step takes, beside the memory's bandwidth",
       {"--part", "--scale", "--scratch", "--out"},
       speed::part_names(),
       speed::experiment_file_names(),
       run_speed}};
  return all;
}

}  // namespace rigcal
