#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/io/frame_files.h"
#include "core/rig/rig.h"
#include "drivers/turntable/table.h"

namespace rigcal {

/// How the table of a rig is to be spoken to; nothing where it is turned by hand.
[[nodiscard]] std::optional<turntable::TableOptions> table_options(const Rig& rig);

/// A table that turns itself, during a capture: what it says of its angle goes into turntable.csv.
class TableRecorder {
 public:
  /// Errors: the disk.
  [[nodiscard]] static Expected<std::unique_ptr<TableRecorder>> create(std::unique_ptr<turntable::Table> table,
                                                                       const std::string& session);

  void turn_by(double degrees) { table_->turn_by(degrees); }
  /// What it said since the last call, which is written down, too.
  [[nodiscard]] std::vector<turntable::TableEvent> take_events();
  [[nodiscard]] std::optional<double> angle_deg() const { return table_->angle_deg(); }
  [[nodiscard]] const Heartbeat& heartbeat() const { return table_->heartbeat(); }
  [[nodiscard]] std::size_t most_waiting() const { return table_->most_waiting(); }
  /// What went wrong with the disk.
  [[nodiscard]] const std::optional<Error>& failure() const { return failure_; }

 private:
  TableRecorder(std::unique_ptr<turntable::Table> table, TurntableTable angles)
      : table_(std::move(table)), angles_(std::move(angles)) {}

  std::unique_ptr<turntable::Table> table_;
  TurntableTable angles_;
  std::optional<TableAngle> written_;
  std::optional<Error> failure_;
};

}  // namespace rigcal
