#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "apps/batch/batch_run.h"
#include "apps/batch/batch_table.h"
#include "apps/commands/calibrate_options.h"
#include "apps/commands/command.h"
#include "apps/commands/option_checks.h"
#include "apps/common/byte_size.h"
#include "core/base/parallel.h"
#include "core/io/extrinsics_file.h"
#include "core/rig/rig.h"

namespace rigcal {
namespace {

struct BatchCommand {
  std::vector<std::string> inputs;
  std::string list;
  CalibrateOptions calibration;
  batch::BatchOptions batch;
};

Expected<ExitCode> run_batch_command(const BatchCommand& command, CommandContext& context) {
  std::vector<std::string> inputs = command.inputs;
  if (!command.list.empty()) {
    const Expected<std::vector<std::string>> listed = batch::read_list(command.list);
    if (!listed) return listed.error();
    inputs.insert(inputs.end(), listed->begin(), listed->end());
  }
  // What would be wrong with each recording is said once.
  if (!command.calibration.rig.empty()) {
    if (const Expected<Rig> rig = load_rig(command.calibration.rig); !rig) return rig.error();
  }
  if (const std::string& initial = command.calibration.initial; !initial.empty() && initial != no_guess) {
    if (const auto rough = load_extrinsics(initial); !rough) return rough.error();
  }
  const Expected<std::vector<batch::Session>> sessions = batch::name_sessions(inputs);
  if (!sessions) return sessions.error();
  batch::BatchOptions options = command.batch;
  options.threads = thread_count();
  options.arguments = arguments_of(command.calibration);
  for (const auto& setting : settings_of(command.calibration)) {
    if (setting.first != "INPUT") options.settings.push_back(setting);
  }
  for (const std::string& input : inputs_of(command.calibration)) {
    if (!input.empty()) options.inputs.push_back(input);
  }
  const batch::BatchWatcher watcher{
      [&](const std::string& what, double fraction) { context.reporter.progress(what, fraction); },
      [&](const std::string& line) { context.reporter.news(line); }};
  const Expected<batch::BatchOutcome> outcome = batch::run_batch(*sessions, options, watcher, context.stop);
  if (!outcome) return outcome.error();
  if (context.json) {
    CommandContext::print(batch::batch_json(*outcome, options.out));
  } else if (!context.quiet) {
    context.reporter.clear();
    CommandContext::print(batch::batch_text(*outcome, options.out));
  }
  for (const batch::SessionRow& row : outcome->rows) {
    if (row.status != "good") return ExitCode::not_trustworthy;
  }
  return ExitCode::good;
}

}  // namespace

void add_batch_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<BatchCommand>();
  CLI::App* command = app.add_subcommand("batch", "Calibrate many recordings, each into a result of its own");
  command->add_option("INPUT", options->inputs, "Recordings, as calibrate takes them");
  command->add_option("--list", options->list, "A file with the path of a recording on each line; -: standard input")
      ->option_text("FILE");
  command
      ->add_option("--out", options->batch.out,
                   "The batch's folder: DIR/NAME is the result of each recording, DIR/batch.csv the table of all; what "
                   "is done there already is kept")
      ->required()
      ->check(named_path())
      ->option_text("DIR");
  command->add_option("--jobs", options->batch.jobs, "Calibrations at a time (default: as many as --threads)")
      ->check(CLI::Range(1, 1024))
      ->option_text("N");
  command
      ->add_option_function<std::string>(
          "--memory", [options](const std::string& text) { options->batch.memory = *parse_bytes(text); },
          "What they may take together, like 16GB (default: nine tenths of what is available); no new one begins "
          "where it would not fit")
      ->check(CLI::Validator(check_bytes, ""))
      ->option_text("SIZE");
  command->add_flag("--retry", options->batch.retry, "Also try those again whose input was at fault before");
  add_calibration_options(*command, options->calibration);
  command->footer("Example:\n  rigcal batch fleet/* --out results\n  rigcal batch --list fleet.txt --out results");
  command->callback([options, command, &context] {
    check_calibration_options(options->calibration, *command);
    if (options->inputs.empty() && options->list.empty()) throw CLI::RequiredError("INPUT or --list FILE");
    // What a list says is known later, and is an input.
    if (options->list.empty()) {
      if (const auto named = batch::name_sessions(options->inputs); !named)
        throw CLI::ValidationError("INPUT", named.error().message());
    }
    context.run = [options, &context] { return run_batch_command(*options, context); };
  });
}

}  // namespace rigcal
