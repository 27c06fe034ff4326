#include "core/io/session_lock.h"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>

namespace rigcal {

std::optional<SessionLock> SessionLock::take(const std::string& session) {
  SessionLock lock(FileDescriptor(::open(session.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)));
  if (!lock.folder_.is_open() || ::flock(lock.folder_.get(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK)
    return lock;
  return std::nullopt;
}

}  // namespace rigcal
