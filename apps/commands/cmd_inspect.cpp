#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "apps/commands/command.h"
#include "apps/common/json_text.h"
#include "apps/exchange/session_repair.h"
#include "apps/inspection/inspection.h"
#include "core/io/session_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

struct InspectOptions {
  std::string path;
  std::string other;  ///< A second result, or empty.
  std::string rig;
  bool repair = false;
};

// A folder, what stands in it, or what `export --format json` made of it, under any name.
bool is_result(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return fs::exists(fs::path(path) / "extrinsics.yaml", error);
  const std::string ending = fs::path(path).extension().string();
  if (ending == ".yaml" || ending == ".yml" || ending == ".json") return true;
  if (!fs::is_regular_file(path, error)) return false;  // What a pipe has given it does not give again.
  std::string begin(16, '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return begin.rfind("rigcal:", 0) == 0 || begin.rfind("{\n  \"rigcal\"", 0) == 0;
}

Expected<Inspection> inspect(const InspectOptions& options, const RunContext& context) {
  std::error_code error;
  if (!options.other.empty()) return inspect_two_results(options.path, options.other);
  if (is_result(options.path)) return inspect_result(options.path);
  if (fs::is_directory(options.path, error)) {
    if (!is_session_folder(options.path)) {
      const std::string own = (fs::path(options.path) / "rig.yaml").string();
      return inspect_patches(options.path, options.rig.empty() && fs::exists(own, error) ? own : options.rig, context);
    }
    const Expected<SessionFolder> session = open_session(options.path);
    if (!session) return session.error();
    if (session->packets.empty()) return inspect_patch_session(*session, options.rig, context);
  } else if (options.rig.empty()) {
    return inspect_stream(options.path, context);
  }
  const Expected<StreamSource> source = open_stream(options.path, options.rig);
  if (!source) return source.error();
  return inspect_recording(*source, context);
}

Expected<ExitCode> run_inspect(const InspectOptions& options, CommandContext& context) {
  std::vector<std::string> repairs;
  if (options.repair) {
    Expected<std::vector<std::string>> done = repair_session(options.path, context.run_context());
    if (!done) return done.error();
    repairs = *std::move(done);
    context.reporter.clear();
  }
  Expected<Inspection> inspection = inspect(options, context.run_context());
  if (!inspection) return inspection.error();
  if (options.repair) (*inspection)["repairs"] = repairs;
  for (const auto& warning : inspection->at("warnings")) context.reporter.warn(warning.get<std::string>());
  if (context.json) {
    CommandContext::print(json_text(*inspection));
  } else if (!context.quiet) {
    CommandContext::print(inspection_text(*inspection));
  }
  const bool trustworthy = inspection->value("complete", true) && inspection->value("same", true) &&
                           inspection->value("status", "good") == "good";
  return trustworthy ? ExitCode::good : ExitCode::not_trustworthy;
}

}  // namespace

void add_inspect_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<InspectOptions>();
  CLI::App* command = app.add_subcommand("inspect", "Show what is in a dump, bag, session, patch folder or result");
  command->add_option("PATH", options->path, "A dump, .lvx file, bag, session, patch folder or result")->required();
  command->add_option("OTHER", options->other, "A second result: says which sensors moved between the two");
  command->add_option("--rig", options->rig, "Rig file: then the stops of a dump or bag are shown too")
      ->option_text("RIG");
  command->add_flag(
      "--repair", options->repair,
      "Finish a session that was cut short (power cut, full disk), so that it is as if it had been ended");
  command->footer("Example:\n  rigcal inspect run.pcap --rig rig.yaml");
  command->callback([options, &context] {
    if (!options->rig.empty() && (!options->other.empty() || is_result(options->path)))
      throw CLI::ValidationError("--rig", "is of no use with a result, which has no stops; leave it away");
    context.run = [options, &context] { return run_inspect(*options, context); };
  });
}

}  // namespace rigcal
