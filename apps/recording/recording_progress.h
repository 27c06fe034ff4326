#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <utility>

namespace rigcal {

/// What the writer of a session's packets tells those who read them meanwhile: how many files there were and whether
/// more will come. Where only the newest packets are kept, a file gets another name when the next one begins.
class RecordingProgress {
 public:
  explicit RecordingProgress(std::string path) : path_(std::move(path)) {}

  /// Of the newest file (see `session_packets_path`).
  [[nodiscard]] const std::string& path() const { return path_; }
  /// Files so far; they are counted from 1.
  [[nodiscard]] int parts() const { return parts_; }
  [[nodiscard]] bool has_ended() const { return has_ended_; }

  /// Held by the writer while files change their names, and by a reader while it opens one.
  [[nodiscard]] std::mutex& switching() { return switching_; }
  /// By the writer.
  void begin_part() { ++parts_; }
  void end() { has_ended_ = true; }

 private:
  std::string path_;
  std::atomic<int> parts_{1};
  std::atomic<bool> has_ended_{false};
  std::mutex switching_;
};

}  // namespace rigcal
