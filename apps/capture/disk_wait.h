#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "core/base/heartbeat.h"

namespace rigcal {

/// How long a disk that takes nothing is waited for at a capture's end.
struct DiskPatience {
  std::chrono::nanoseconds told_after = std::chrono::seconds(5);
  std::chrono::nanoseconds most = std::chrono::seconds(60);
  /// Where nothing shows whether the disk is blocked or slow: what waits in memory may take a card minutes.
  std::chrono::nanoseconds most_unseen = std::chrono::minutes(10);
  /// Both are called from another thread, `tell` once a wait, `give_up` in place of the wait's end: it is to end the
  /// program, as nothing takes a thread out of a system call. May be empty.
  std::function<void(const std::string& what)> tell;
  std::function<void(std::chrono::nanoseconds waited)> give_up;
};

/// Looks after a wait that may last as long as the disk is blocked, while it lives. A disk that is slow is not given
/// up: time counts from when the thread that is waited for last moved.
class DiskWait {
 public:
  /// `patience` must outlive it. `what` is to be taken by the disk. `worker` may be null.
  DiskWait(const DiskPatience& patience, std::string what, const Heartbeat* worker);
  ~DiskWait();
  DiskWait(const DiskWait&) = delete;
  DiskWait& operator=(const DiskWait&) = delete;

 private:
  void look(const std::stop_token& stop) const;

  const DiskPatience& patience_;
  std::string what_;
  const Heartbeat* worker_;
  std::jthread thread_;
};

}  // namespace rigcal
