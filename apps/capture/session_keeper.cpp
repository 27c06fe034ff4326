#include "apps/capture/session_keeper.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <utility>

#include "core/base/file_descriptor.h"
#include "core/base/seconds.h"

namespace rigcal {

// The number of a session's files is not bounded: the whole file system is asked for at once.
Expected<void> sync_session(const std::string& session) {
  const FileDescriptor folder(::open(session.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  const int code = !folder.is_open() || ::syncfs(folder.get()) != 0 ? errno : 0;
  if (code == 0) return {};
  return system_error(std::string("the disk lost some of what was recorded: ") + std::strerror(code), session,
                      "look after the disk and its cable (dmesg), see what is left with rigcal inspect, record anew");
}

struct SessionKeeper::State {
  State(std::string folder, Sync how) : session(std::move(folder)), sync(std::move(how)) {}

  const std::string session;
  const Sync sync;
  Heartbeat heartbeat{"securing"};
  std::mutex mutex;
  std::condition_variable changed;
  std::optional<SessionRecord> next;
  bool may_write = true;
  bool is_writing = false;
  bool is_over = false;
  bool is_synced = false;  ///< To the end.
  bool has_ended = false;
  std::uint64_t secured = 0;
  std::optional<Error> failure;
  std::optional<Error> loss;
  double worst_s = 0.0;

  void run() {
    while (true) {
      std::optional<SessionRecord> record;
      bool is_last = false;
      {
        std::unique_lock lock(mutex);
        changed.wait(lock, [this] { return next || is_over; });
        is_last = is_over;
        if (may_write) record = std::exchange(next, std::nullopt);
        next.reset();
        is_writing = record.has_value();
      }
      heartbeat.beat();
      const auto begun = SteadyClock::now();
      Expected<void> written;
      if (record) written = write_session_record(session, *record);
      {
        const std::lock_guard lock(mutex);
        is_writing = false;
        if (!written && !failure) failure = written.error();
        changed.notify_all();
      }
      Expected<void> synced;
      if (written && (record || is_last)) synced = sync(session);
      heartbeat.beat();
      heartbeat.rest();
      const std::lock_guard lock(mutex);
      const double took = seconds_since(begun);
      worst_s = std::max(worst_s, took);
      if (!synced && !loss) loss = synced.error();
      if (record && written && synced) ++secured;
      if (!is_last && written) continue;
      is_synced = is_last && written && synced;
      has_ended = true;
      changed.notify_all();
      return;
    }
  }
};

SessionKeeper::SessionKeeper(std::string session, Sync sync)
    : state_(std::make_shared<State>(std::move(session), std::move(sync))) {
  thread_ = std::thread([state = state_] { state->run(); });
}

SessionKeeper::~SessionKeeper() { static_cast<void>(finish(std::chrono::seconds(2))); }

void SessionKeeper::secure(SessionRecord record) {
  const std::lock_guard lock(state_->mutex);
  state_->next = std::move(record);
  state_->changed.notify_all();
}

void SessionKeeper::stop_writing() {
  std::unique_lock lock(state_->mutex);
  state_->may_write = false;
  state_->changed.wait(lock, [this] { return !state_->is_writing; });
}

bool SessionKeeper::finish(std::chrono::nanoseconds longest) {
  std::unique_lock lock(state_->mutex);
  state_->may_write = false;
  state_->is_over = true;
  state_->changed.notify_all();
  const bool has_ended = state_->changed.wait_for(lock, longest, [this] { return state_->has_ended; });
  const bool is_synced = state_->is_synced;
  lock.unlock();
  if (thread_.joinable()) {
    if (has_ended) {
      thread_.join();
    } else {
      thread_.detach();
    }
  }
  return is_synced;
}

std::uint64_t SessionKeeper::secured() const {
  const std::lock_guard lock(state_->mutex);
  return state_->secured;
}

std::optional<Error> SessionKeeper::failure() const {
  const std::lock_guard lock(state_->mutex);
  return state_->failure;
}

std::optional<Error> SessionKeeper::loss() const {
  const std::lock_guard lock(state_->mutex);
  return state_->loss;
}

double SessionKeeper::worst_s() const {
  const std::lock_guard lock(state_->mutex);
  return state_->worst_s;
}

const Heartbeat& SessionKeeper::heartbeat() const { return state_->heartbeat; }

}  // namespace rigcal
