#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/commands/command.h"

namespace rigcal {

/// Options of every command, as a sentence names them.
inline constexpr const char* global_option_names = "--threads, --json, --quiet and --log-level";

/// Options of every command.
struct GlobalOptions {
  std::string level = "info";
  int threads = 0;
};

/// The words of --log-level.
[[nodiscard]] const std::map<std::string, LogLevel>& log_levels();

/// Declares the whole command line: what `rigcal` parses, and what its man pages and completions are made from. `app`
/// is fresh; all that is passed must outlive it.
void describe_command_line(CLI::App& app, CommandContext& context, GlobalOptions& options);

/// The commands of what was so declared, in the order in which --help lists them.
[[nodiscard]] std::vector<const CLI::App*> commands_of(const CLI::App& app);

/// Takes what stands on the command line into `context` and `options`. With an exit code that is all there is to do:
/// help was asked for, or what was given is wrong, and that has been said.
[[nodiscard]] std::optional<ExitCode> parse_command_line(int argc, char** argv, CommandContext& context,
                                                         GlobalOptions& options);

}  // namespace rigcal
