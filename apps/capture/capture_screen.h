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
/// must not hold up the one that looks after trigger, disk and table, nor the calibration after it. Bounded: of
/// statuses and of progress the newest waits, of sentences the first hundreds.
class CaptureScreen final : public Reporter {
 public:
  /// All outlive it, and are called from its thread alone. `tell` shows a line that the user needs.
  CaptureScreen(Reporter& reporter, std::function<void(const CaptureStatus&)> draw,
                std::function<void(const std::string&)> tell);
  ~CaptureScreen() override;
  CaptureScreen(const CaptureScreen&) = delete;
  CaptureScreen& operator=(const CaptureScreen&) = delete;

  /// These return at once.
  void show(const CaptureStatus& status);
  void progress(std::string_view stage, double fraction) override;
  void warn(std::string message) override { say({std::move(message), Sentence::Kind::warning}); }
  void debug(std::string message) override { say({std::move(message), Sentence::Kind::remark}); }
  void tell(std::string line) { say({std::move(line), Sentence::Kind::told}); }
  /// Until then nobody sees progress, as the status shows how far it is.
  void show_progress();

  /// Shows what still waits, as long as that takes, and ends.
  void finish();

 private:
  struct Sentence {
    enum class Kind { remark, told, warning };
    std::string text;
    Kind kind = Kind::remark;
  };
  struct Progress {
    std::string stage;
    double fraction = 0.0;
  };
  void say(Sentence sentence);
  void pass_on(Sentence sentence);
  void run();

  Reporter& reporter_;
  std::function<void(const CaptureStatus&)> draw_;
  std::function<void(const std::string&)> tell_;
  std::mutex mutex_;
  std::condition_variable wanted_;
  std::optional<CaptureStatus> next_;
  std::optional<Progress> progress_;
  bool shows_progress_ = false;
  std::deque<Sentence> sentences_;
  std::size_t unsaid_ = 0;
  bool is_over_ = false;
  std::thread thread_;
};

}  // namespace rigcal
