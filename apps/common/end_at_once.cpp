#include "apps/common/end_at_once.h"

#include <poll.h>
#include <unistd.h>

#include <cstdlib>

namespace rigcal {

void end_at_once(std::string_view words, ExitCode code) {
  pollfd taker{STDERR_FILENO, POLLOUT, 0};
  if (poll(&taker, 1, 0) == 1 && (taker.revents & POLLOUT) != 0) {
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, words.data(), words.size());
  }
  std::_Exit(static_cast<int>(code));
}

}  // namespace rigcal
