#include <CLI/CLI.hpp>
#include <memory>
#include <optional>

#include "apps/command.h"
#include "apps/planes_experiment_text.h"
#include "apps/sigma_experiment.h"
#include "apps/start_experiment.h"
#include "core/io/output_file.h"
#include "core/io/staged_folder.h"

namespace rigcal {
namespace {

struct ExperimentOptions {
  std::string paper;
  int trials = 100;
  int mountings = 1000;
  int places = 10;
  SigmaExperimentOptions sigma;
  StartExperimentOptions start;
  std::optional<int> rigs;  // of sigma and start
  std::uint64_t seed = 1;
  std::string out;
};

Expected<PlanesExperiment> run_planes(const ExperimentOptions& options, const RunContext& context) {
  PlanesExperiment experiment;
  experiment.trials = options.trials;
  Expected<std::vector<CornerRow>> table = repeat_table(options.trials, options.seed, context);
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

Expected<ExitCode> run_start(const ExperimentOptions& options, CommandContext& context) {
  StartExperimentOptions start = options.start;
  start.seed = options.seed;
  start.rigs = options.rigs.value_or(start.rigs);
  const Expected<std::vector<StartRow>> rows = try_starts(start, context.run_context());
  if (!rows) return rows.error();
  if (context.json) {
    CommandContext::print(start_experiment_json(*rows));
  } else if (!context.quiet) {
    CommandContext::print(start_experiment_text(*rows));
  }
  return ExitCode::good;
}

Expected<ExitCode> run_experiment(const ExperimentOptions& options, CommandContext& context) {
  if (options.paper == "sigma") return run_sigma(options, context);
  if (options.paper == "start") return run_start(options, context);
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

}  // namespace

void add_experiment_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<ExperimentOptions>();
  CLI::App* command =
      app.add_subcommand("experiment", "Repeat the experiments behind the figures in the documentation");
  command
      ->add_option(
          "PAPER", options->paper,
          "planes: LiDARs from the planes of a corner; sigma: whether errors are as large as sigma says; start: "
          "how many random rigs are found without a guess")
      ->required()
      ->check(CLI::IsMember({"planes", "sigma", "start"}));
  command->add_option("--trials", options->trials, "Trials of each row of the paper's table (default 100)")
      ->check(CLI::Range(1, 100000))
      ->option_text("N");
  command->add_option("--mountings", options->mountings, "Corners with a random mounting (default 1000)")
      ->check(CLI::Range(1, 1000000))
      ->option_text("N");
  command->add_option("--places", options->places, "Places of the simulated vehicle (default 10)")
      ->check(CLI::Range(1, 1000))
      ->option_text("N");
  command
      ->add_option("--rigs", options->rigs, "sigma: rigs of each kind of errors (default 60); start: of each case (20)")
      ->check(CLI::Range(1, 100000))
      ->option_text("N");
  command->add_option("--points", options->start.points, "start: points of each patch (default 20000)")
      ->check(CLI::Range(1000, 1000000))
      ->option_text("N");
  command->add_option("--case", options->start.cases, "start: only this case; may be repeated")
      ->check(CLI::IsMember(start_case_names()))
      ->option_text("NAME");
  command->add_option("--seed", options->seed, "Of all random numbers (default 1)")->option_text("N");
  command->add_option("--out", options->out, "Also writes the tables and pictures of the clouds into this folder")
      ->option_text("DIR");
  command->footer(
      "Example:\n  rigcal experiment planes --trials 100 --out planes\n  rigcal experiment sigma --rigs 60 --out "
      "sigma\n  rigcal experiment start --rigs 20 --case gyro");
  command->callback(
      [options, &context] { context.run = [options, &context] { return run_experiment(*options, context); }; });
}

}  // namespace rigcal
