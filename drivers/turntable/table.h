#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "core/base/heartbeat.h"
#include "drivers/net/session_clock.h"
#include "drivers/turntable/ascii_protocol.h"
#include "drivers/turntable/grbl_protocol.h"
#include "drivers/turntable/serial_port.h"

namespace rigcal::turntable {

enum class ProtocolKind { grbl, ascii };

struct TableOptions {
  std::string port;
  int baud = 115200;
  ProtocolKind protocol = ProtocolKind::grbl;
  GrblOptions grbl;
  AsciiOptions ascii;
  bool is_reversed = false;  ///< The table counts against the right-hand rule about the rig file's axis.
};

/// News of a table with the session time at which they came.
struct TableEvent : TableNews {
  std::int64_t stamp_ns = 0;
};

/// A turntable on a serial port, in a thread of its own: it is asked where it is ten times a second and told to turn.
/// Angles are degrees, right-handed about the rig file's axis. A port that is lost is looked for until it is back.
class Table {
 public:
  /// Errors: the options (kind input), a port that cannot be had (kind system).
  [[nodiscard]] static Expected<std::unique_ptr<Table>> start(const TableOptions& options,
                                                              const net::ClockReading& session_start);
  /// Stops a motion that goes on, where the protocol can, and ends.
  ~Table();
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

  /// From any thread; returns at once.
  void turn_by(double degrees);
  /// Since the last call, in order; at most some thousands are kept.
  [[nodiscard]] std::vector<TableEvent> take_events();
  /// Where it was last.
  [[nodiscard]] std::optional<double> angle_deg() const;
  [[nodiscard]] const Heartbeat& heartbeat() const { return heartbeat_; }
  /// Most events that have waited to be taken.
  [[nodiscard]] std::size_t most_waiting() const;

 private:
  Table(const TableOptions& options, SerialPort port, const net::ClockReading& session_start);
  void run();
  Expected<void> talk(SerialPort& port);
  void tell(const std::vector<TableNews>& news);
  [[nodiscard]] double angle_by_table() const;  ///< As it counts itself; 0 where it is not known.

  TableOptions options_;
  net::SessionClock clock_;
  std::unique_ptr<TableProtocol> protocol_;
  std::optional<SerialPort> port_;  ///< Of the thread.
  std::atomic<bool> is_stopped_{false};
  Heartbeat heartbeat_{"turntable"};
  mutable std::mutex mutex_;  ///< Of what follows.
  std::optional<double> to_turn_;
  std::vector<TableEvent> events_;
  std::size_t most_waiting_ = 0;
  std::optional<double> angle_deg_;
  std::thread thread_;
};

}  // namespace rigcal::turntable
