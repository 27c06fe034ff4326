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
///
/// A board that restarts counts from zero; the angles that are told go on from where the table was last.
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
  void take_line(const std::string& line, double now_s);
  void take_report(const std::string& line, double now_s);
  void take_angle(double counted_deg);
  void take_state(const std::string& state, double now_s);
  void send_if_possible();
  void send_move();
  void restart(double now_s);

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
  std::optional<double> angle_deg_;  ///< Where it was last, also before the line was opened anew.
  bool has_reported_ = false;        ///< Since the line was opened, or the board has restarted.
  bool has_restarted_ = false;       ///< Since the last report.
  double offset_deg_ = 0.0;          ///< From what the board counts to what is told.
  bool is_held_ = false;             ///< It takes no move, and goes on with the last one when somebody lets it.
  bool may_free_ = false;            ///< A hold is what an earlier run has left.
  std::string told_state_;           ///< In which it does not turn.
};

}  // namespace rigcal::turntable
