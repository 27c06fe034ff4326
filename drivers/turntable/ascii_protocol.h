#pragma once

#include <optional>
#include <string>

#include "drivers/turntable/line_splitter.h"
#include "drivers/turntable/table_protocol.h"

namespace rigcal::turntable {

/// How a table with commands in plain words is spoken to. Each is one line.
struct AsciiOptions {
  std::string move = "MOVE {angle}";   ///< {angle}: degrees where it is to go to, {step}: by how many it is to turn.
  std::string ask = "POS?";            ///< Asks where it is; empty: it cannot be asked.
  std::string answer = "POS {angle}";  ///< Its answer: what stands before the number.
  std::string done;           ///< The line by which it tells that it has arrived; empty: it is where it was told to be.
  std::string fault = "ERR";  ///< Lines that begin like this tell of a fault.
};

/// What is wrong with them, one clause; empty where nothing is.
[[nodiscard]] std::string fault_of(const AsciiOptions& options);

/// Plain words over a serial line. A move is done at the line `done`; without one, when two answers in a row say that
/// the table is where it was told to go.
class AsciiProtocol final : public TableProtocol {
 public:
  /// Options that `fault_of` finds good.
  explicit AsciiProtocol(const AsciiOptions& options) : options_(options) {}

  void open(double now_s) override;
  void turn_by(double degrees, double now_s) override;
  void receive(std::string_view bytes, double now_s) override;
  void tick(double now_s) override;

 private:
  void take_line(const std::string& line);
  void take_angle(double angle_deg);
  void send_move();
  /// Where a table is told by how much to turn, and cannot be asked where it is, nobody knows whether it has turned
  /// when its answer got lost: told once more it might turn twice.
  [[nodiscard]] bool may_repeat() const;
  void arrive();

  AsciiOptions options_;
  LineSplitter lines_;
  std::optional<double> angle_deg_;  ///< As the table counts.
  double offset_deg_ = 0.0;          ///< From that to what is told; 0 where it can be asked.
  std::optional<double> to_turn_;    ///< Told, not yet sent: where it is has to be known first.
  double target_deg_ = 0.0;          ///< Of the last move.
  bool has_target_ = false;
  bool is_moving_ = false;
  int answers_there_ = 0;
};

}  // namespace rigcal::turntable
