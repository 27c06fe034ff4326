#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>

#include "apps/commands/command.h"
#include "apps/commands/experiments.h"
#include "apps/commands/option_checks.h"
#include "core/io/output_file.h"
#include "core/io/staged_folder.h"

namespace rigcal {
namespace {

constexpr const char* text_file = "table.txt";
constexpr const char* json_file = "table.json";

Expected<void> write_folder(const ExperimentFindings& findings, StagedFolder& folder) {
  auto files = findings.files;
  files.emplace_back(text_file, findings.text);
  files.emplace_back(json_file, findings.json);
  for (const auto& [name, text] : files) {
    if (const auto done = replace_file(folder.path() + "/" + name, text); !done) return done;
  }
  return folder.commit();
}

Expected<ExitCode> run_experiment(const Experiment& experiment, const ExperimentOptions& options,
                                  CommandContext& context) {
  std::optional<StagedFolder> folder;
  if (!options.out.empty()) {
    std::vector<std::string> names = experiment.files;
    names.insert(names.end(), {text_file, json_file});
    Expected<StagedFolder> made = StagedFolder::replace(options.out, std::move(names));
    if (!made) return made.error();
    folder.emplace(std::move(*made));
  }
  const Expected<ExperimentFindings> findings = experiment.run(options, context.run_context());
  if (!findings) return findings.error();
  if (folder) {
    if (const auto done = write_folder(*findings, *folder); !done) return done.error();
  }
  if (context.json) {
    CommandContext::print(findings->json);
  } else if (!context.quiet) {
    CommandContext::print(findings->text);
  }
  return ExitCode::good;
}

bool holds(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::vector<std::string> experiment_names() {
  std::vector<std::string> names;
  for (const Experiment& experiment : experiments()) names.push_back(experiment.name);
  return names;
}

std::string experiments_text() {
  std::string text;
  for (const Experiment& experiment : experiments())
    text += (text.empty() ? "" : "; ") + experiment.name + ": " + experiment.what;
  return text;
}

const Experiment& experiment_of(const std::string& name) {
  return *std::find_if(experiments().begin(), experiments().end(),
                       [&](const Experiment& experiment) { return experiment.name == name; });
}

void check_parts(const Experiment& experiment, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) {
    if (holds(experiment.parts, part)) continue;
    throw CLI::ValidationError("--part", experiment.name + " has no part '" + part + "'");
  }
}

/// Who gives an experiment an option that it does not read would take its figures for others. What none lists is read
/// by all.
void check_options(const CLI::App& command, const Experiment& experiment) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || holds(experiment.options, option->get_name())) continue;
    std::vector<std::string> readers;
    for (const Experiment& other : experiments()) {
      if (holds(other.options, option->get_name())) readers.push_back(other.name);
    }
    if (readers.empty()) continue;
    throw CLI::ValidationError(option->get_name(),
                               "is of " + fmt::format("{}", fmt::join(readers, ", ")) + ", not of " + experiment.name);
  }
}

}  // namespace

void add_experiment_command(CLI::App& app, CommandContext& context) {
  const auto name = std::make_shared<std::string>();
  const auto options = std::make_shared<ExperimentOptions>();
  CLI::App* command =
      app.add_subcommand("experiment", "Repeat the experiments behind the figures in the documentation");
  command->add_option("EXPERIMENT", *name, experiments_text())->required()->check(CLI::IsMember(experiment_names()));
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
  command->callback([name, options, command, &context] {
    const Experiment& experiment = experiment_of(*name);
    check_options(*command, experiment);
    check_parts(experiment, options->parts);
    context.run = [&experiment, options, &context] { return run_experiment(experiment, *options, context); };
  });
}

}  // namespace rigcal
