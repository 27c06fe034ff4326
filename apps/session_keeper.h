#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "core/base/heartbeat.h"
#include "core/io/session_folder.h"

namespace rigcal {

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
  /// Why session.json could not be written, the first time that it could not, which ends the keeping.
  [[nodiscard]] std::optional<Error> failure() const;
  [[nodiscard]] double worst_s() const;  ///< The longest that it took.
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
  std::optional<Error> failure_;
  double worst_s_ = 0.0;
  std::thread thread_;
};

}  // namespace rigcal
