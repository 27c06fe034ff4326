#pragma once

#include <map>
#include <string>

#include "apps/commands/command.h"

namespace rigcal {

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

}  // namespace rigcal
