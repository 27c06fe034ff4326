#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/commands/command.h"
#include "apps/commands/option_checks.h"
#include "apps/common/json_text.h"
#include "apps/exchange/session_import.h"
#include "core/base/text.h"
#include "core/base/version.h"

namespace rigcal {
namespace {

struct ImportOptions {
  std::string input;
  std::string out;
  std::string rig;
  std::string images;
};

std::string summary_text(const ImportOptions& options, const ImportSummary& done) {
  if (done.datagrams > 0) {
    const std::string images = done.images > 0 ? ", " + counted(done.images, "image") : "";
    return options.out + ": " + std::to_string(done.datagrams) + " datagrams" + images + "\n";
  }
  const std::string points = fixed_text(1e-6 * static_cast<double>(done.points), 1) + " million points";
  return options.out + ": " + counted(done.stops, "stop") + ", " + points + ", " + counted(done.images, "image") + "\n";
}

std::string summary_json(const ImportOptions& options, const ImportSummary& done) {
  const nlohmann::ordered_json json{
      {"rigcal", format_version}, {"command", "import"},       {"kind", done.kind},
      {"out", options.out},       {"complete", done.complete}, {"datagrams", done.datagrams},
      {"stops", done.stops},      {"points", done.points},     {"images", done.images}};
  return json_text(json);
}

Expected<ExitCode> run_import(const ImportOptions& options, CommandContext& context) {
  const Expected<ImportSummary> done =
      import_session({options.input, options.rig, options.images}, options.out, context.run_context());
  if (!done) return done.error();
  if (context.json) {
    CommandContext::print(summary_json(options, *done));
  } else if (!context.quiet) {
    CommandContext::print(summary_text(options, *done));
  }
  return done->complete ? ExitCode::good : ExitCode::not_trustworthy;
}

}  // namespace

void add_import_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<ImportOptions>();
  CLI::App* command = app.add_subcommand("import", "Turn a dump, an .lvx file, a bag or a patch folder into a session");
  command->add_option("INPUT", options->input, "A packet dump, a Livox .lvx file, a ROS 1 bag or a patch folder")
      ->required();
  command->add_option("--out", options->out, "The session to make; must not exist")
      ->required()
      ->check(named_path())
      ->option_text("SESSION");
  command->add_option("--rig", options->rig, "The rig file (a patch folder may bring its own)")->option_text("RIG");
  command
      ->add_option("--images", options->images,
                   "The cameras' images where they do not lie with the recording: DIR/<camera>/ as in a session")
      ->option_text("DIR");
  command->footer("Example:\n  rigcal import run.bag --rig rig.yaml --out session");
  command->callback(
      [options, &context] { context.run = [options, &context] { return run_import(*options, context); }; });
}

}  // namespace rigcal
