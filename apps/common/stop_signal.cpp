#include "apps/common/stop_signal.h"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <optional>
#include <string_view>

#include "apps/common/end_at_once.h"
#include "core/base/seconds.h"
#include "core/base/system_call.h"

namespace rigcal {
namespace {

constexpr std::string_view second_signal =
    "rigcal: error: ended at once by a second signal: what was being written is left as it was; "
    "a session is finished by rigcal inspect --repair SESSION\n";

// One that is blocked comes even where it is ignored.
bool is_ignored(int signal) {
  struct sigaction action {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

sigset_t stop_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  if (!is_ignored(SIGHUP)) sigaddset(&set, SIGHUP);
  return set;
}

}  // namespace

StopSignal::StopSignal() : set_(stop_signals()) {
  signals_ = FileDescriptor(signalfd(-1, &set_, SFD_CLOEXEC));
  wake_ = FileDescriptor(eventfd(0, EFD_CLOEXEC));
  if (!signals_.is_open() || !wake_.is_open()) {
    ready_ = call_error("cannot watch for Ctrl-C", errno);
    return;
  }
  pthread_sigmask(SIG_BLOCK, &set_, nullptr);
  thread_ = std::thread([this] { listen(); });
}

StopSignal::~StopSignal() {
  if (thread_.joinable()) {
    const std::uint64_t one = 1;
    // An eventfd with room takes eight bytes whole; there is nobody to tell if it did not.
    [[maybe_unused]] const ssize_t written = write(wake_.get(), &one, sizeof(one));
    thread_.join();
    pthread_sigmask(SIG_UNBLOCK, &set_, nullptr);
  }
}

void StopSignal::listen() {
  std::array<pollfd, 2> watched{{{signals_.get(), POLLIN, 0}, {wake_.get(), POLLIN, 0}}};
  std::optional<SteadyClock::time_point> told;
  while (true) {
    if (poll(watched.data(), watched.size(), -1) < 0) {
      if (errno == EINTR) continue;
      return;
    }
    if (watched[1].revents != 0) return;
    signalfd_siginfo signal{};
    if (read(signals_.get(), &signal, sizeof(signal)) != static_cast<ssize_t>(sizeof(signal))) continue;
    if (told && signal.ssi_signo != SIGHUP && SteadyClock::now() - *told >= kOneWish)
      end_at_once(second_signal, ExitCode::not_trustworthy);
    if (!told) told = SteadyClock::now();
    source_.request_stop();
  }
}

}  // namespace rigcal
