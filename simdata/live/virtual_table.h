#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "core/base/file_descriptor.h"

namespace rigcal::sim {

struct VirtualTableOptions {
  bool speaks_grbl = true;  ///< Otherwise "MOVE a", "POS?" and "POS a".
  double degrees_per_s = 40.0;
  /// The place to reach it by, a link to its pseudo-terminal; empty: by `port` alone.
  std::string link;
};

/// A turntable on a pseudo-terminal, in a thread of its own. It turns by itself when it is told to, or follows a run
/// that turns whatever it is told (`follow`); then it says that it is on its way from when it is told to turn until the
/// run has turned and rests again.
class VirtualTable {
 public:
  /// Errors (kind system): no pseudo-terminals; the link cannot be made.
  [[nodiscard]] static Expected<std::unique_ptr<VirtualTable>> start(const VirtualTableOptions& options);
  ~VirtualTable();
  VirtualTable(const VirtualTable&) = delete;
  VirtualTable& operator=(const VirtualTable&) = delete;

  /// A path that can be opened like a serial port.
  [[nodiscard]] const std::string& port() const { return port_; }
  [[nodiscard]] double angle_deg() const;
  /// It takes commands and does not move.
  void jam(bool is_jammed) { is_jammed_ = is_jammed; }
  /// Its angle is that of a run from now on.
  void follow(double angle_deg);

 private:
  VirtualTable(const VirtualTableOptions& options, FileDescriptor terminal, FileDescriptor held_open, std::string port);
  void run();
  void advance();
  void take(char c);
  void obey(char c);
  void take_line();
  void order_move(double to_deg);
  [[nodiscard]] bool is_turning() const;
  void answer(const std::string& text) const;

  VirtualTableOptions options_;
  FileDescriptor terminal_;
  FileDescriptor held_open_;  ///< Of the other end, so that it outlives its users.
  std::string port_;
  std::string line_;
  double told_s_ = 0.0;  ///< Of the clock, when it last moved.
  std::atomic<bool> is_jammed_{false};
  std::atomic<bool> is_stopped_{false};
  mutable std::mutex mutex_;  ///< Of what follows.
  double angle_deg_ = 0.0;
  double target_deg_ = 0.0;
  bool follows_ = false;
  bool is_held_ = false;
  bool awaits_turn_ = false;  ///< Told to turn, and the run has not turned yet.
  double changed_s_ = -1e9;   ///< When the run's angle last changed.
  std::thread thread_;
};

}  // namespace rigcal::sim
