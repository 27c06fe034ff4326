#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "apps/heartbeat.h"
#include "core/io/session_folder.h"

namespace rigcal {

/// What there is to write to, and how long it lasts.
struct DiskRoom {
  std::uint64_t free_bytes = 0;
  double bytes_per_s = 0.0;            ///< As the session grew lately.
  std::optional<double> seconds_left;  ///< Until the recording would be ended; nothing where nothing grows.
};

/// How long a disk lasts that has so much room, when a session grows like this; pure.
class DiskForecast {
 public:
  /// What is always left free: session.json and the last images have to get in.
  static constexpr std::uint64_t kReserveBytes = 32ULL << 20U;

  /// `session_bytes`: of everything that was written so far. Times in seconds of a clock that never goes back.
  [[nodiscard]] DiskRoom add(double now_s, std::uint64_t session_bytes, std::uint64_t free_bytes);

 private:
  double last_s_ = -1.0;
  std::uint64_t last_bytes_ = 0;
  double bytes_per_s_ = 0.0;
};

/// Brings a session that is being recorded to the disk, now and then and after each stop: session.json as it stands,
/// and all files with what was handed to the system. In a thread of its own: a disk that is slow holds nobody up.
class SessionKeeper {
 public:
  explicit SessionKeeper(std::string session);
  /// Waits for what is under way.
  ~SessionKeeper();
  SessionKeeper(const SessionKeeper&) = delete;
  SessionKeeper& operator=(const SessionKeeper&) = delete;

  /// Asks for it; returns at once. What was asked for before and has not begun is replaced.
  void secure(SessionRecord record);
  /// Ends after what is under way; what has not begun is left out.
  void finish();

  [[nodiscard]] std::uint64_t secured() const;  ///< Times.
  [[nodiscard]] double worst_s() const;         ///< The longest that it took.
  [[nodiscard]] const Heartbeat& heartbeat() const { return heartbeat_; }

 private:
  void run();

  std::string session_;
  Heartbeat heartbeat_{"securing"};
  mutable std::mutex mutex_;
  std::condition_variable wanted_;
  std::optional<SessionRecord> next_;
  bool is_over_ = false;
  std::uint64_t secured_ = 0;
  double worst_s_ = 0.0;
  std::thread thread_;
};

/// Free bytes where the session lies; nothing where the system does not say.
[[nodiscard]] std::optional<std::uint64_t> free_bytes(const std::string& session);

}  // namespace rigcal
