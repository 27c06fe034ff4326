#include "tests/support/run_program.h"

#include <sys/wait.h>

#include <cstdlib>

#include "tests/support/files.h"

namespace rigcal {

ProgramRun run_program(const std::string& command, const std::filesystem::path& scratch) {
  const std::filesystem::path out = scratch / "stdout.txt";
  const std::filesystem::path err = scratch / "stderr.txt";
  const std::string line = "(" + command + ") >'" + out.string() + "' 2>'" + err.string() + "' </dev/null";
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(out), text_of(err)};
}

ProgramRun run_rigcal(const std::string& arguments, const std::filesystem::path& folder, const std::string& piped) {
  const std::string before = piped.empty() ? piped : piped + " | ";
  return run_program("cd '" + folder.string() + "' && " + before + "'" + RIGCAL_PROGRAM + "' " + arguments, folder);
}

}  // namespace rigcal
