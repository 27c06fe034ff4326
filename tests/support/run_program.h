#pragma once

#include <filesystem>
#include <string>

namespace rigcal {

/// How a program ended and what it said.
struct ProgramRun {
  int code = -1;  ///< Exit code; -1 where it was ended by a signal.
  std::string out;
  std::string err;
};

/// Runs a shell command line; `scratch` is a folder for what it says.
ProgramRun run_program(const std::string& command, const std::filesystem::path& scratch);

/// Runs rigcal with these arguments in this folder, which is for what it says, too. `piped`: a command there whose
/// output is its /dev/stdin.
ProgramRun run_rigcal(const std::string& arguments, const std::filesystem::path& folder, const std::string& piped = {});

}  // namespace rigcal
