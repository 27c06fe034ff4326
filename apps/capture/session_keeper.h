#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "core/base/heartbeat.h"
#include "core/io/session_folder.h"

namespace rigcal {

/// Brings everything of a session that was handed to the system to the disk; an Error where the disk lost some of it.
[[nodiscard]] Expected<void> sync_session(const std::string& session);

/// Brings a session that is being recorded to the disk, now and then and after each stop: session.json as it stands,
/// and all files with what was handed to the system. In a thread of its own: a disk that is slow holds nobody up.
class SessionKeeper {
 public:
  using Sync = std::function<Expected<void>(const std::string& session)>;

  explicit SessionKeeper(std::string session, Sync sync = sync_session);
  /// As `finish` within 2 s.
  ~SessionKeeper();
  SessionKeeper(const SessionKeeper&) = delete;
  SessionKeeper& operator=(const SessionKeeper&) = delete;

  /// Asks for it; returns at once. What was asked for before and has not begun is replaced.
  void secure(SessionRecord record);
  /// From now on session.json is the caller's. Waits for one that is being written, but not for the disk to take all.
  void stop_writing();
  /// Brings all to the disk once more, and ends. Waits for so long at most: a disk that others keep busy must not keep
  /// a capture from ending. Whether it is there; otherwise the system goes on with it.
  [[nodiscard]] bool finish(std::chrono::nanoseconds longest);

  [[nodiscard]] std::uint64_t secured() const;  ///< Times that all of it was brought to the disk.
  /// Why session.json could not be written, the first time that it could not, which ends the keeping.
  [[nodiscard]] std::optional<Error> failure() const;
  /// What the disk said the first time that it lost something. It goes on being asked: the rest may be worth having.
  [[nodiscard]] std::optional<Error> loss() const;
  [[nodiscard]] double worst_s() const;  ///< The longest that it took.
  [[nodiscard]] const Heartbeat& heartbeat() const;

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< Also the thread's, which may outlive this where the disk does not answer.
  std::thread thread_;
};

}  // namespace rigcal
