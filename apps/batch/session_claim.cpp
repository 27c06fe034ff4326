#include "apps/batch/session_claim.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/io/output_file.h"

namespace rigcal::batch {

Expected<std::optional<SessionClaim>> SessionClaim::take(const std::string& path) {
  // For writing: NFS gives exclusive locks on nothing else.
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) return cannot_write(path, errno);
  SessionClaim claim(descriptor);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return std::optional<SessionClaim>(std::move(claim));
  if (errno == EWOULDBLOCK) return std::optional<SessionClaim>();
  return system_error(std::string("cannot lock it: ") + std::strerror(errno), path,
                      "choose an --out on a file system that has locks (flock)");
}

SessionClaim::SessionClaim(SessionClaim&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

SessionClaim& SessionClaim::operator=(SessionClaim&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

SessionClaim::~SessionClaim() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace rigcal::batch
