#include "drivers/net/waiter.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

#include "core/base/file_descriptor.h"
#include "core/base/seconds.h"
#include "core/base/system_call.h"

namespace rigcal::net {

struct Waiter::State {
  FileDescriptor event;
  std::vector<pollfd> watched;  ///< The event last.
};

Waiter::Waiter(std::unique_ptr<State> state) : state_(std::move(state)) {}
Waiter::~Waiter() = default;
Waiter::Waiter(Waiter&&) noexcept = default;
Waiter& Waiter::operator=(Waiter&&) noexcept = default;

Expected<Waiter> Waiter::create(const std::vector<int>& descriptors) {
  if (descriptors.size() > kMost)
    return system_error("too many sockets to wait for", {}, "record fewer sensors with one program");
  auto state = std::make_unique<State>();
  state->event = FileDescriptor(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!state->event.is_open()) return call_error("cannot make an event", errno);
  for (const int descriptor : descriptors) state->watched.push_back({descriptor, POLLIN, 0});
  state->watched.push_back({state->event.get(), POLLIN, 0});
  return Waiter(std::move(state));
}

bool Waiter::wait(std::int64_t timeout_ns) {
  const timespec timeout{timeout_ns / ns_per_second, timeout_ns % ns_per_second};
  const int ready = ppoll(state_->watched.data(), state_->watched.size(), timeout_ns < 0 ? nullptr : &timeout, nullptr);
  if (ready <= 0) {
    for (pollfd& watched : state_->watched) watched.revents = 0;
    return false;
  }
  if (state_->watched.back().revents != 0) {
    std::uint64_t count = 0;
    // Nothing to read means that another wait has taken it already.
    [[maybe_unused]] const ssize_t taken = read(state_->event.get(), &count, sizeof count);
  }
  return true;
}

bool Waiter::is_ready(std::size_t index) const { return state_->watched[index].revents != 0; }

void Waiter::wake() const {
  const std::uint64_t one = 1;
  // Full means that it is awake anyway.
  [[maybe_unused]] const ssize_t written = write(state_->event.get(), &one, sizeof one);
}

}  // namespace rigcal::net
