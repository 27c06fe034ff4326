#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "apps/capture/capture_status.h"
#include "core/base/run_context.h"

namespace rigcal {

/// Shows a capture in a thread of its own: a terminal that takes nothing any more (Ctrl-S, an ssh line that stalls)
/// must not hold up the one that looks after trigger, disk and table. Bounded: of statuses the newest waits, of
/// sentences the first hundreds.
class CaptureScreen final : public Reporter {
 public:
  /// Both outlive it, and are called from its thread alone.
  CaptureScreen(Reporter& reporter, std::function<void(const CaptureStatus&)> draw);
  ~CaptureScreen() override;
  CaptureScreen(const CaptureScreen&) = delete;
  CaptureScreen& operator=(const CaptureScreen&) = delete;

  /// These return at once.
  void show(const CaptureStatus& status);
  void progress(std::string_view, double) override {}  ///< The status shows how far it is.
  void warn(std::string message) override { say({std::move(message), true}); }
  void debug(std::string message) override { say({std::move(message), false}); }

  /// Shows what still waits, as long as that takes, and ends.
  void finish();

 private:
  struct Sentence {
    std::string text;
    bool is_warning = false;
  };
  void say(Sentence sentence);
  void run();

  Reporter& reporter_;
  std::function<void(const CaptureStatus&)> draw_;
  std::mutex mutex_;
  std::condition_variable wanted_;
  std::optional<CaptureStatus> next_;
  std::deque<Sentence> sentences_;
  std::size_t unsaid_ = 0;
  bool is_over_ = false;
  std::thread thread_;
};

}  // namespace rigcal
