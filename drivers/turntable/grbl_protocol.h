#pragma once

#include <optional>
#include <string>

#include "drivers/turntable/line_splitter.h"
#include "drivers/turntable/table_protocol.h"

namespace rigcal::turntable {

struct GrblOptions {
  char letter = 'X';  ///< The axis that turns the table: X, Y, Z, A, B or C; one unit is a degree.
  double degrees_per_s = 10.0;
};

/// G-code as grbl 1.1 speaks it (github.com/gnea/grbl/wiki, "Grbl v1.1 Interface" and "Commands"): relative moves in
/// units of a degree, "ok" or "error:N" for each line, "?" for a report like <Idle|MPos:18.000,0.000,0.000|FS:0,0>. A
/// move is done when its line was taken and a report that was asked for after that says Idle.
class GrblProtocol final : public TableProtocol {
 public:
  explicit GrblProtocol(const GrblOptions& options) : options_(options) {}

  void open(double now_s) override;
  void turn_by(double degrees, double now_s) override;
  void receive(std::string_view bytes, double now_s) override;
  void tick(double now_s) override;
  /// A feed hold, of a table that moves: one that rests would be held, too, and take no move until somebody lets it go.
  void close() override {
    if (is_moving_) say("!");
  }

 private:
  void take_line(const std::string& line);
  void take_report(const std::string& line);
  void send_move();

  GrblOptions options_;
  LineSplitter lines_;
  double ready_s_ = 0.0;  ///< Nothing is said before: a board that restarts loses it.
  bool is_ready_ = false;
  std::optional<double> to_turn_;    ///< Told, not yet sent.
  std::optional<double> start_deg_;  ///< Of the move that goes on.
  double moved_by_ = 0.0;            ///< That is what it is to turn.
  bool is_moving_ = false;
  bool is_taken_ = false;  ///< The table has said "ok" to the move.
  int asked_after_taken_ = 0;
  std::optional<double> angle_deg_;
};

}  // namespace rigcal::turntable
