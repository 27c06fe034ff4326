#pragma once

#include <chrono>
#include <csignal>
#include <stop_token>
#include <thread>

#include "core/base/error.h"
#include "core/base/file_descriptor.h"

namespace rigcal {

/// Turns Ctrl-C (SIGINT), SIGTERM and the end of the terminal (SIGHUP, unless it was ignored before, as nohup does)
/// into a stop request while it lives. The signals are blocked and read by a thread of its own, so nothing runs inside
/// a signal handler; make it before any other thread starts. A second signal ends the program at once, for work that
/// does not listen; not SIGHUP, which shell and system may both send, and not one that comes within `kOneWish` of the
/// first: `timeout`, and wrappers in a terminal, send each signal twice.
class StopSignal {
 public:
  static constexpr std::chrono::milliseconds kOneWish{1000};

  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  /// Not usable where the system refused a descriptor: then the signals keep their usual effect.
  [[nodiscard]] const Expected<void>& ready() const { return ready_; }
  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }

 private:
  void listen();

  sigset_t set_{};
  std::stop_source source_;
  FileDescriptor signals_;  ///< signalfd
  FileDescriptor wake_;     ///< eventfd: the destructor's way to end the thread.
  Expected<void> ready_;
  std::thread thread_;
};

}  // namespace rigcal
