#include "apps/session_keeper.h"

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <utility>

namespace rigcal {
namespace {

// Everything that was handed to the system, of all files of the session: their number is not bounded.
void sync_files(const std::string& session) {
  const int folder = ::open(session.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  static_cast<void>(::syncfs(folder));
  ::close(folder);
}

}  // namespace

SessionKeeper::SessionKeeper(std::string session) : session_(std::move(session)) {
  thread_ = std::thread([this] { run(); });
}

SessionKeeper::~SessionKeeper() { finish(); }

void SessionKeeper::finish() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    wanted_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

void SessionKeeper::secure(SessionRecord record) {
  const std::lock_guard lock(mutex_);
  next_ = std::move(record);
  wanted_.notify_all();
}

std::uint64_t SessionKeeper::secured() const {
  const std::lock_guard lock(mutex_);
  return secured_;
}

std::optional<Error> SessionKeeper::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

double SessionKeeper::worst_s() const {
  const std::lock_guard lock(mutex_);
  return worst_s_;
}

void SessionKeeper::run() {
  while (true) {
    SessionRecord record;
    {
      std::unique_lock lock(mutex_);
      wanted_.wait(lock, [this] { return next_ || is_over_; });
      if (is_over_) return;
      record = *std::exchange(next_, std::nullopt);
    }
    heartbeat_.beat();
    const auto begun = std::chrono::steady_clock::now();
    const Expected<void> written = write_session_record(session_, record);
    if (written) sync_files(session_);
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    heartbeat_.beat();
    heartbeat_.rest();
    const std::lock_guard lock(mutex_);
    if (!written) {
      failure_ = written.error();
      return;
    }
    ++secured_;
    worst_s_ = std::max(worst_s_, took);
  }
}

}  // namespace rigcal
