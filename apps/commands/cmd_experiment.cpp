#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>

#include "apps/commands/command.h"
#include "apps/commands/known_files.h"
#include "apps/commands/option_checks.h"
#include "apps/common/kept_memory.h"
#include "apps/experiment/base_experiment.h"
#include "apps/experiment/board_experiment_text.h"
#include "apps/experiment/bound/bound_experiment.h"
#include "apps/experiment/planes_experiment_text.h"
#include "apps/experiment/sigma_experiment.h"
#include "apps/experiment/speed/experiment.h"
#include "apps/experiment/start_experiment.h"
#include "apps/experiment/targetless/experiment.h"
#include "core/base/parallel.h"
#include "core/io/output_file.h"
#include "core/io/staged_folder.h"

namespace rigcal {
namespace {

/// The parts of the checkerboard experiment that `--part` may name.
constexpr std::array<const char*, 4> board_parts{"pairs", "curves", "detection", "livox"};

struct ExperimentOptions {
  std::string paper;
  std::optional<int> trials;  // of planes and targetless
  std::optional<int> points;  // of a patch: targetless, bound, start and base
  int mountings = 1000;
  int places = 10;
  SigmaExperimentOptions sigma;
  StartExperimentOptions start;
  BoardDrawOptions boards;
  int shown = 100;
  std::vector<std::string> parts;        // of checkerboard, speed and targetless; empty: all
  bool no_guess = false;                 // of base
  bool no_gyro = false;                  // likewise
  std::optional<int> rigs;               // of checkerboard, sigma, bound, start and base
  double scale = 1.0;                    // of speed
  std::string scratch = "rigcal-speed";  // likewise
  std::uint64_t seed = 1;
  std::string out;
};

Expected<PlanesExperiment> run_planes(const ExperimentOptions& options, const RunContext& context) {
  PlanesExperiment experiment;
  experiment.trials = options.trials.value_or(100);
  Expected<std::vector<CornerRow>> table = repeat_table(experiment.trials, options.seed, context);
  if (!table) return table.error();
  experiment.table = std::move(*table);
  const Expected<MountingFigures> mountings = try_mountings(options.mountings, options.seed, context);
  if (!mountings) return mountings.error();
  experiment.mountings = *mountings;
  Expected<VehicleExperiment> vehicle = drive_vehicle(options.places, options.seed, context);
  if (!vehicle) return vehicle.error();
  experiment.vehicle = std::move(*vehicle);
  return experiment;
}

using Files = std::vector<std::pair<std::string, std::string>>;

Files planes_files(const PlanesExperiment& experiment) {
  const VehicleMoment& moment = experiment.vehicle.moment;
  return {{"table.txt", planes_experiment_text(experiment)},
          {"table.json", planes_experiment_json(experiment)},
          {"before.svg",
           moment_svg(moment, moment.T_guess, "Two LiDARs of a vehicle from above, by a guess without turns")},
          {"after.svg", moment_svg(moment, moment.T_found, "The same, as calibrated")}};
}

Expected<void> write_folder(const Files& files, StagedFolder& folder) {
  for (const auto& [name, text] : files) {
    if (const auto done = replace_file(folder.path() + "/" + name, text); !done) return done;
  }
  return folder.commit();
}

Expected<ExitCode> run_sigma(const ExperimentOptions& options, CommandContext& context) {
  std::optional<StagedFolder> folder;
  if (!options.out.empty()) {
    Expected<StagedFolder> made = StagedFolder::replace(options.out, {"table.txt", "table.json", "nees.svg"});
    if (!made) return made.error();
    folder.emplace(std::move(*made));
  }
  SigmaExperimentOptions sigma = options.sigma;
  sigma.seed = options.seed;
  sigma.rigs = options.rigs.value_or(sigma.rigs);
  const Expected<std::vector<SigmaRow>> rows = try_sigmas(sigma, context.run_context());
  if (!rows) return rows.error();
  if (folder) {
    const Files files{{"table.txt", sigma_experiment_text(*rows)},
                      {"table.json", sigma_experiment_json(*rows)},
                      {"nees.svg", nees_svg(*rows)}};
    if (const auto done = write_folder(files, *folder); !done) return done.error();
  }
  if (context.json) {
    CommandContext::print(sigma_experiment_json(*rows));
  } else if (!context.quiet) {
    CommandContext::print(sigma_experiment_text(*rows));
  }
  return ExitCode::good;
}

Expected<ExitCode> run_bound(const ExperimentOptions& options, CommandContext& context) {
  std::optional<StagedFolder> folder;
  if (!options.out.empty()) {
    Expected<StagedFolder> made = StagedFolder::replace(options.out, {"table.txt", "table.json"});
    if (!made) return made.error();
    folder.emplace(std::move(*made));
  }
  bound::BoundExperimentOptions chosen;
  chosen.seed = options.seed;
  chosen.rigs = options.rigs.value_or(chosen.rigs);
  chosen.points = options.points.value_or(chosen.points);
  const Expected<bound::BoundExperiment> experiment = bound::try_bounds(chosen, context.run_context());
  if (!experiment) return experiment.error();
  const std::string text = bound::bound_experiment_text(*experiment);
  const std::string json = bound::bound_experiment_json(*experiment);
  if (folder) {
    if (const auto done = write_folder({{"table.txt", text}, {"table.json", json}}, *folder); !done)
      return done.error();
  }
  if (context.json || !context.quiet) CommandContext::print(context.json ? json : text);
  return ExitCode::good;
}

Expected<ExitCode> run_start(const ExperimentOptions& options, CommandContext& context) {
  StartExperimentOptions start = options.start;
  start.seed = options.seed;
  start.rigs = options.rigs.value_or(start.rigs);
  start.points = options.points.value_or(start.points);
  const Expected<std::vector<StartRow>> rows = try_starts(start, context.run_context());
  if (!rows) return rows.error();
  if (context.json) {
    CommandContext::print(start_experiment_json(*rows));
  } else if (!context.quiet) {
    CommandContext::print(start_experiment_text(*rows));
  }
  return ExitCode::good;
}

Expected<BoardExperiment> run_parts(const ExperimentOptions& options, const RunContext& context) {
  const auto wanted = [&](const char* part) {
    return options.parts.empty() || std::find(options.parts.begin(), options.parts.end(), part) != options.parts.end();
  };
  BoardExperiment experiment;
  if (wanted("pairs") || wanted("curves")) {
    BoardDrawOptions draws = options.boards;
    draws.seed = options.seed;
    draws.asked_only = !wanted("curves");
    Expected<std::vector<BoardRow>> rows = draw_boards(draws, context);
    if (!rows) return rows.error();
    experiment.rows = std::move(*rows);
  }
  if (wanted("detection")) {
    Expected<std::vector<DetectionRow>> rows = detect_boards(options.shown, options.seed, context);
    if (!rows) return rows.error();
    experiment.detection = std::move(*rows);
  }
  if (wanted("livox")) {
    LivoxBoardOptions livox;
    livox.rigs = options.rigs.value_or(livox.rigs);
    livox.seed = options.seed;
    Expected<std::vector<LivoxRow>> rows = try_livox_boards(livox, context);
    if (!rows) return rows.error();
    experiment.livox = std::move(*rows);
  }
  return experiment;
}

Expected<ExitCode> run_checkerboard(const ExperimentOptions& options, CommandContext& context) {
  std::optional<StagedFolder> folder;
  if (!options.out.empty()) {
    Expected<StagedFolder> made = StagedFolder::replace(options.out, board_experiment_files());
    if (!made) return made.error();
    folder.emplace(std::move(*made));
  }
  const Expected<BoardExperiment> experiment = run_parts(options, context.run_context());
  if (!experiment) return experiment.error();
  const std::string text = board_experiment_text(*experiment);
  const std::string json = board_experiment_json(*experiment);
  if (folder) {
    Files files = board_experiment_pictures(experiment->rows);
    files.emplace_back("table.txt", text);
    files.emplace_back("table.json", json);
    if (const auto done = write_folder(files, *folder); !done) return done.error();
  }
  if (context.json) {
    CommandContext::print(json);
  } else if (!context.quiet) {
    CommandContext::print(text);
  }
  return ExitCode::good;
}

Expected<ExitCode> run_targetless(const ExperimentOptions& options, CommandContext& context) {
  std::optional<StagedFolder> folder;
  if (!options.out.empty()) {
    Expected<StagedFolder> made = StagedFolder::replace(options.out, targetless::experiment_file_names());
    if (!made) return made.error();
    folder.emplace(std::move(*made));
  }
  const auto experiment =
      targetless::run_parts({options.parts, options.trials, options.seed, options.points}, context.run_context());
  if (!experiment) return experiment.error();
  if (folder) {
    if (const auto done = write_folder(targetless::experiment_files(*experiment), *folder); !done) return done.error();
  }
  if (context.json) {
    CommandContext::print(targetless::experiment_json(*experiment));
  } else if (!context.quiet) {
    CommandContext::print(targetless::experiment_text(*experiment));
  }
  return ExitCode::good;
}

Expected<ExitCode> run_speed(const ExperimentOptions& options, CommandContext& context) {
  keep_freed_memory();  // as calibrate
  std::optional<StagedFolder> folder;
  if (!options.out.empty()) {
    Expected<StagedFolder> made = StagedFolder::replace(options.out, speed::experiment_file_names());
    if (!made) return made.error();
    folder.emplace(std::move(*made));
  }
  speed::ExperimentOptions what{options.parts, options.scale, options.seed, {}, {}};
  what.programs.rig = rig_file("turntable");
  what.programs.scratch = options.scratch;
  what.programs.threads = thread_count();
  const auto experiment = speed::run_parts(what, context.run_context());
  if (!experiment) return experiment.error();
  if (folder) {
    if (const auto done = write_folder(speed::experiment_files(*experiment), *folder); !done) return done.error();
  }
  if (context.json) {
    CommandContext::print(speed::experiment_json(*experiment));
  } else if (!context.quiet) {
    CommandContext::print(speed::experiment_text(*experiment));
  }
  return ExitCode::good;
}

Expected<ExitCode> run_base(const ExperimentOptions& options, CommandContext& context) {
  BaseExperimentOptions base;
  base.seed = options.seed;
  base.points = options.points.value_or(base.points);
  base.with_guess = !options.no_guess;
  base.with_gyro = !options.no_gyro;
  base.rigs = options.rigs.value_or(base.rigs);
  const Expected<std::vector<BaseRow>> rows = try_bases(base, context.run_context());
  if (!rows) return rows.error();
  if (context.json) {
    CommandContext::print(base_experiment_json(*rows));
  } else if (!context.quiet) {
    CommandContext::print(base_experiment_text(*rows));
  }
  return ExitCode::good;
}

Expected<ExitCode> run_experiment(const ExperimentOptions& options, CommandContext& context) {
  if (options.paper == "checkerboard") return run_checkerboard(options, context);
  if (options.paper == "sigma") return run_sigma(options, context);
  if (options.paper == "bound") return run_bound(options, context);
  if (options.paper == "start") return run_start(options, context);
  if (options.paper == "base") return run_base(options, context);
  if (options.paper == "targetless") return run_targetless(options, context);
  if (options.paper == "speed") return run_speed(options, context);
  std::optional<StagedFolder> folder;
  if (!options.out.empty()) {
    Expected<StagedFolder> made =
        StagedFolder::replace(options.out, {"table.txt", "table.json", "before.svg", "after.svg"});
    if (!made) return made.error();
    folder.emplace(std::move(*made));
  }
  const Expected<PlanesExperiment> experiment = run_planes(options, context.run_context());
  if (!experiment) return experiment.error();
  if (folder) {
    if (const auto done = write_folder(planes_files(*experiment), *folder); !done) return done.error();
  }
  if (context.json) {
    CommandContext::print(planes_experiment_json(*experiment));
  } else if (!context.quiet) {
    CommandContext::print(planes_experiment_text(*experiment));
  }
  return ExitCode::good;
}

std::vector<std::string> parts_of(const std::string& paper) {
  if (paper == "targetless") return targetless::part_names();
  if (paper == "speed") return speed::part_names();
  if (paper == "checkerboard") return {board_parts.begin(), board_parts.end()};
  return {};
}

void check_parts(const ExperimentOptions& options) {
  const std::vector<std::string> known = parts_of(options.paper);
  for (const std::string& part : options.parts) {
    if (std::find(known.begin(), known.end(), part) != known.end()) continue;
    throw CLI::ValidationError("--part", options.paper + " has no part '" + part + "'");
  }
}

/// Which experiments read an option; what is not named here is read by all.
const std::map<std::string, std::vector<std::string>>& readers() {
  static const std::map<std::string, std::vector<std::string>> all{
      {"--trials", {"targetless", "planes"}},
      {"--mountings", {"planes"}},
      {"--places", {"planes"}},
      {"--draws", {"checkerboard"}},
      {"--sets", {"checkerboard"}},
      {"--boards", {"checkerboard"}},
      {"--part", {"targetless", "checkerboard", "speed"}},
      {"--scale", {"speed"}},
      {"--scratch", {"speed"}},
      {"--rigs", {"checkerboard", "sigma", "bound", "start", "base"}},
      {"--points", {"targetless", "bound", "start", "base"}},
      {"--case", {"start"}},
      {"--basin", {"start"}},
      {"--no-guess", {"base"}},
      {"--no-gyro", {"base"}},
      {"--out", {"targetless", "planes", "checkerboard", "sigma", "bound", "speed"}}};
  return all;
}

/// Who gives an experiment an option that it does not read would take its figures for others.
void check_options(const CLI::App& command, const std::string& paper) {
  for (const CLI::Option* option : command.get_options()) {
    const auto found = readers().find(option->get_name());
    if (option->count() == 0 || found == readers().end()) continue;
    const std::vector<std::string>& papers = found->second;
    if (std::find(papers.begin(), papers.end(), paper) != papers.end()) continue;
    throw CLI::ValidationError(found->first,
                               "is of " + fmt::format("{}", fmt::join(papers, ", ")) + ", not of " + paper);
  }
}

}  // namespace

void add_experiment_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<ExperimentOptions>();
  CLI::App* command =
      app.add_subcommand("experiment", "Repeat the experiments behind the figures in the documentation");
  command
      ->add_option("PAPER", options->paper,
                   "targetless: the main method, beside ICP and others; planes: LiDARs from the planes of a corner; "
                   "checkerboard: LiDARs and cameras by a board; sigma: whether "
                   "errors are as large as sigma says; bound: how far errors are above what the noise allows; start: "
                   "how many random rigs are found without a guess; base: whether the "
                   "choice of the base changes a result; speed: what each step takes, beside the memory's bandwidth")
      ->required()
      ->check(CLI::IsMember({"targetless", "planes", "checkerboard", "sigma", "bound", "start", "base", "speed"}));
  command
      ->add_option(
          "--trials", options->trials,
          "planes: trials of each row of the paper's table (default 100); targetless: of each setting (default: "
          "some minutes' worth)")
      ->check(CLI::Range(1, 100000))
      ->option_text("N");
  command->add_option("--mountings", options->mountings, "planes: corners with a random mounting (default 1000)")
      ->check(CLI::Range(1, 1000000))
      ->option_text("N");
  command->add_option("--places", options->places, "planes: places of the simulated vehicle (default 10)")
      ->check(CLI::Range(1, 1000))
      ->option_text("N");
  command
      ->add_option("--draws", options->boards.draws,
                   "checkerboard: draws of 10 poses at the paper's noise (default 1000; elsewhere a twentieth)")
      ->check(CLI::Range(1, 1000000))
      ->option_text("N");
  command->add_option("--sets", options->boards.sets, "checkerboard: sets of 27 poses to draw from (default 4)")
      ->check(CLI::Range(1, 1000))
      ->option_text("N");
  command->add_option("--boards", options->shown, "checkerboard: boards shown for detection (default 100)")
      ->check(CLI::Range(3, 100000))
      ->option_text("N");
  command
      ->add_option("--part", options->parts,
                   "checkerboard: only pairs (10 poses), curves (3 to 20), detection or livox; targetless: only "
                   "iterations, basin, chain, time or cameras; speed: only programs (runs of rigcal itself), stages, "
                   "scans or growth; may be repeated")
      ->option_text("NAME");
  command->add_option("--scale", options->scale, "speed: of all numbers of points (default 1)")
      ->check(number_range(0.001, 1.0))
      ->option_text("SHARE");
  command
      ->add_option(
          "--scratch", options->scratch,
          "speed: folder for simulated runs of 2 GB; made, and removed at the end (default: rigcal-speed here)")
      ->option_text("DIR");
  command
      ->add_option("--rigs", options->rigs,
                   "sigma: rigs of each kind of errors (default 60); bound: rigs (30); start: of each case (20); "
                   "checkerboard: with each "
                   "Livox sensor (10); base: rigs (6)")
      ->check(CLI::Range(1, 100000))
      ->option_text("N");
  command
      ->add_option("--points", options->points,
                   "targetless, bound, start, base: points of each patch (default 20000; targetless, cameras: 100000)")
      ->check(CLI::Range(1000, 1000000))
      ->option_text("N");
  command->add_option("--case", options->start.cases, "start: only this case; may be repeated")
      ->check(CLI::IsMember(start_case_names()))
      ->option_text("NAME");
  command->add_flag("--basin", options->start.basin,
                    "start: ever worse guesses, from 1 m and 20 degrees on, until fewer than 99 of 100 rigs are right");
  command->add_flag("--no-guess", options->no_guess, "base: without a guess");
  command->add_flag("--no-gyro", options->no_gyro, "base: without the turns by a gyro");
  command->add_option("--seed", options->seed, "Of all random numbers (default 1)")
      ->check(seed_range())
      ->option_text("N");
  command
      ->add_option("--out", options->out, "Also writes tables and pictures into this folder (all but start and base)")
      ->check(named_path())
      ->option_text("DIR");
  command->footer(
      "Example:\n  rigcal experiment targetless --part iterations --trials 4 --out targetless\n  rigcal experiment "
      "planes --trials 100 --out planes\n  rigcal experiment checkerboard --part pairs "
      "--draws 100\n  rigcal experiment sigma --rigs 60 --out sigma\n  rigcal experiment start --rigs 20 --case gyro");
  command->callback([options, command, &context] {
    check_options(*command, options->paper);
    check_parts(*options);
    context.run = [options, &context] { return run_experiment(*options, context); };
  });
}

}  // namespace rigcal
