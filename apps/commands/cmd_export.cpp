#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "apps/commands/command.h"
#include "apps/commands/option_checks.h"
#include "apps/commands/result_export.h"
#include "apps/common/json_text.h"
#include "apps/exchange/patch_export.h"
#include "core/base/text.h"
#include "core/base/version.h"

namespace rigcal {
namespace {

struct ExportOptions {
  std::string path;
  std::string format;
  std::string out;
  std::string rig;
};

std::string summary_text(const ExportOptions& options, const PatchExport& done) {
  const std::string points =
      fixed_text(1e-6 * static_cast<double>(done.reading.points.in_stops), 1) + " million points";
  return options.out + ": " + counted(done.reading.stops.size(), "stop") + ", " + points + " in " +
         counted(done.files, "file") + (done.images > 0 ? ", " + counted(done.images, "image") : "") + "\n";
}

std::string summary_json(const ExportOptions& options, const PatchExport& done) {
  const nlohmann::ordered_json json{{"rigcal", format_version},
                                    {"command", "export"},
                                    {"format", options.format},
                                    {"out", options.out},
                                    {"stops", done.reading.stops.size()},
                                    {"points", done.reading.points.in_stops},
                                    {"files", done.files},
                                    {"images", done.images}};
  return json_text(json);
}

std::string result_text(const ExportOptions& options, const ResultExport& done) {
  std::string text = options.out + ":";
  for (const std::string& sensor : done.sensors) text += " " + sensor;
  return text + "\n";
}

std::string result_json(const ExportOptions& options, const ResultExport& done) {
  nlohmann::ordered_json json{{"rigcal", format_version}, {"command", "export"},     {"format", options.format},
                              {"out", options.out},       {"sensors", done.sensors}, {"left_out", done.left_out}};
  if (done.is_judged) json["status"] = to_string(done.status);
  return json_text(json);
}

Expected<ExitCode> run_result_export(const ExportOptions& options, ResultFormat format, CommandContext& context) {
  const Expected<ResultExport> done = export_result_file(options.path, options.rig, format, options.out);
  if (!done) return done.error();
  for (const std::string& warning : done->warnings) context.reporter.warn(warning);
  if (context.json) {
    CommandContext::print(result_json(options, *done));
  } else if (!context.quiet) {
    CommandContext::print(result_text(options, *done));
  }
  return exit_code_of(done->status);
}

Expected<ExitCode> run_export(const ExportOptions& options, CommandContext& context) {
  if (const std::optional<ResultFormat> format = result_format(options.format)) {
    return run_result_export(options, *format, context);
  }
  const Expected<StreamSource> source = open_stream(options.path, options.rig);
  if (!source) return source.error();
  const std::map<std::string, PatchLayout> layouts{
      {"patches", PatchLayout::patches}, {"pcd", PatchLayout::pcd}, {"las", PatchLayout::las}};
  const PatchLayout layout = layouts.at(options.format);
  const Expected<PatchExport> done = export_patches(*source, layout, options.out, context.run_context());
  if (!done) return done.error();
  if (context.json) {
    CommandContext::print(summary_json(options, *done));
  } else if (!context.quiet) {
    CommandContext::print(summary_text(options, *done));
  }
  const bool whole = source->complete && done->reading.truncation.empty();
  return whole ? ExitCode::good : ExitCode::not_trustworthy;
}

}  // namespace

void add_export_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<ExportOptions>();
  CLI::App* command =
      app.add_subcommand("export", "Write a result for other tools, or the stops of a recording as patches or clouds");
  command->add_option("PATH", options->path, "A result, a dump, an .lvx file, a bag or a session")->required();
  std::vector<std::string> formats{"patches", "pcd", "las"};
  formats.insert(formats.end(), result_format_names().begin(), result_format_names().end());
  command
      ->add_option("--format", options->format,
                   "Of a recording: patches (a patch folder for calibrate, with images), pcd or las (one cloud a "
                   "sensor and stop, side "
                   "by side). Of a result: ros2-tf, urdf, autoware, kalibr, opencv, colmap, mlcc, fast-livo, json")
      ->required()
      ->check(CLI::IsMember(formats))
      ->option_text("FORMAT");
  command->add_option("--out", options->out, "File or folder to make; must not exist")
      ->required()
      ->check(named_path())
      ->option_text("PATH");
  command
      ->add_option("--rig", options->rig,
                   "Rig file; a session brings its own, a patch folder may; tells which sensors of an extrinsics.yaml "
                   "are cameras, and their intrinsics")
      ->option_text("RIG");
  command->footer("Example:\n  rigcal export result --format ros2-tf --out rig.launch.xml");
  command->callback(
      [options, &context] { context.run = [options, &context] { return run_export(*options, context); }; });
}

}  // namespace rigcal
