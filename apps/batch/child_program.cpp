#include "apps/batch/child_program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "core/base/system_call.h"

namespace rigcal::batch {
namespace {

constexpr const char* own_program = "/proc/self/exe";

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// What a spawned process begins with; freed at the end.
struct SpawnSetup {
  SpawnSetup() {
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
  }
  ~SpawnSetup() {
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
  }
  SpawnSetup(const SpawnSetup&) = delete;
  SpawnSetup& operator=(const SpawnSetup&) = delete;

  posix_spawn_file_actions_t files{};
  posix_spawnattr_t attributes{};
};

}  // namespace

Expected<ChildProgram> ChildProgram::start(const std::vector<std::string>& arguments, const std::string& log,
                                           int kept_descriptor) {
  SpawnSetup setup;
  posix_spawn_file_actions_addopen(&setup.files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&setup.files, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  posix_spawn_file_actions_adddup2(&setup.files, STDOUT_FILENO, STDERR_FILENO);
  // Onto itself: it is not closed at exec then.
  if (kept_descriptor >= 0) posix_spawn_file_actions_adddup2(&setup.files, kept_descriptor, kept_descriptor);
  // Ctrl-C and SIGTERM are blocked here, where a thread reads them.
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&setup.attributes, &none);
  posix_spawnattr_setpgroup(&setup.attributes, 0);
  posix_spawnattr_setflags(&setup.attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);

  std::vector<std::string> words{"rigcal"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> given;
  given.reserve(words.size() + 1);
  for (std::string& word : words) given.push_back(word.data());
  given.push_back(nullptr);
  pid_t id = -1;
  const int refused = posix_spawn(&id, own_program, &setup.files, &setup.attributes, given.data(), environ);
  if (refused != 0) return call_error("cannot start a calibration", refused, log);
  return ChildProgram(id);
}

std::optional<ChildEnd> ChildProgram::ended() const {
  int status = 0;
  rusage usage{};
  if (::wait4(id_, &status, WNOHANG, &usage) != id_) return std::nullopt;
  ChildEnd end;
  if (WIFEXITED(status)) end.code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  end.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  end.peak_memory_mb = static_cast<double>(usage.ru_maxrss) / 1024.0;
  return end;
}

void ChildProgram::stop() const { ::kill(id_, SIGTERM); }

}  // namespace rigcal::batch
