#include "apps/batch/session_claim.h"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/io/output_file.h"

namespace rigcal::batch {

Expected<std::optional<SessionClaim>> SessionClaim::take(const std::string& path) {
  // For writing: NFS gives exclusive locks on nothing else.
  SessionClaim claim(FileDescriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)));
  if (!claim.file_.is_open()) return cannot_write(path, errno);
  if (::flock(claim.descriptor(), LOCK_EX | LOCK_NB) == 0) return std::optional<SessionClaim>(std::move(claim));
  if (errno == EWOULDBLOCK) return std::optional<SessionClaim>();
  return system_error(std::string("cannot lock it: ") + std::strerror(errno), path,
                      "choose an --out on a file system that has locks (flock)");
}

}  // namespace rigcal::batch
