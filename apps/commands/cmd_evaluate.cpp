#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "apps/commands/command.h"
#include "apps/common/tolerance.h"
#include "apps/evaluation/evaluation.h"
#include "apps/evaluation/evaluation_text.h"
#include "apps/evaluation/known_rig.h"

namespace rigcal {
namespace {

struct EvaluateOptions {
  std::string result;
  std::string truth;
  std::string max_error;  ///< Empty: no bounds.
};

Expected<ExitCode> run_evaluate(const EvaluateOptions& options, CommandContext& context) {
  const Expected<KnownRig> result = load_result(options.result);
  if (!result) return result.error();
  const Expected<KnownRig> truth = load_truth(options.truth);
  if (!truth) return truth.error();
  const Expected<Evaluation> evaluation = evaluate(*result, *truth);
  if (!evaluation) return evaluation.error();

  std::optional<bool> within;
  if (!options.max_error.empty()) {
    const Expected<Tolerance> bound = parse_tolerance(options.max_error);
    if (!bound) return bound.error();
    if (!has_sensors(*evaluation)) {
      return input_error("has no sensor besides the base for --max-error to ask about", options.result,
                         "leave --max-error out; the poses are compared without it");
    }
    within = is_within(*evaluation, bound->translation_m, bound->rotation_rad);
  }
  if (context.json) {
    CommandContext::print(evaluation_json(*evaluation, within));
  } else if (!context.quiet) {
    CommandContext::print(evaluation_text(*evaluation));
    if (within) CommandContext::print(std::string(*within ? "within " : "NOT within ") + options.max_error + "\n");
  }
  return within.value_or(true) ? ExitCode::good : ExitCode::not_trustworthy;
}

}  // namespace

void add_evaluate_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<EvaluateOptions>();
  CLI::App* command = app.add_subcommand("evaluate", "Show the errors of a result against known extrinsics");
  command->add_option("RESULT", options->result, "A result folder or an extrinsics.yaml")->required();
  command->add_option("--truth", options->truth, "A result, a ground_truth.yaml or a rig file")
      ->required()
      ->option_text("FILE");
  command
      ->add_option("--max-error", options->max_error,
                   "Exit with 1 when a sensor is off by more or failed, for example 3mm,0.03deg")
      ->check(CLI::Validator(check_tolerance, ""))
      ->option_text("MM,DEG");
  command->footer("Example:\n  rigcal evaluate result --truth session/ground_truth.yaml --max-error 3mm,0.03deg");
  command->callback(
      [options, &context] { context.run = [options, &context] { return run_evaluate(*options, context); }; });
}

}  // namespace rigcal
