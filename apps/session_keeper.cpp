#include "apps/session_keeper.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

namespace rigcal {
namespace {

constexpr double forgets_in_s = 10.0;  // Of the mean of the rate.

// Everything that was handed to the system, of all files of the session: their number is not bounded.
void sync_files(const std::string& session) {
  const int folder = ::open(session.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  static_cast<void>(::syncfs(folder));
  ::close(folder);
}

}  // namespace

DiskRoom DiskForecast::add(double now_s, std::uint64_t session_bytes, std::uint64_t free_bytes) {
  if (last_s_ >= 0.0 && now_s > last_s_) {
    const double grown = static_cast<double>(session_bytes - std::min(last_bytes_, session_bytes));
    const double rate = grown / (now_s - last_s_);
    const double share = bytes_per_s_ == 0.0 ? 1.0 : std::min(1.0, (now_s - last_s_) / forgets_in_s);
    bytes_per_s_ += share * (rate - bytes_per_s_);
  }
  last_s_ = now_s;
  last_bytes_ = session_bytes;
  DiskRoom room{free_bytes, bytes_per_s_, std::nullopt};
  if (bytes_per_s_ >= 1.0)
    room.seconds_left = static_cast<double>(free_bytes - std::min(free_bytes, kReserveBytes)) / bytes_per_s_;
  return room;
}

std::optional<std::uint64_t> free_bytes(const std::string& session) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(session, error);
  if (error || space.available == static_cast<std::uintmax_t>(-1)) return std::nullopt;
  return space.available;
}

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
    // Where it cannot be written, the end of the recording tells.
    static_cast<void>(write_session_record(session_, record));
    sync_files(session_);
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    heartbeat_.beat();
    heartbeat_.rest();
    const std::lock_guard lock(mutex_);
    ++secured_;
    worst_s_ = std::max(worst_s_, took);
  }
}

}  // namespace rigcal
