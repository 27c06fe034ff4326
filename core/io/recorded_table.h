#pragma once

#include <string>

#include "core/base/error.h"

namespace rigcal {

/// A table beside a recording's packets, as far as it is whole. It grows line by line, so a power cut leaves its last
/// line half written, or zeros where bytes had not reached the disk.
struct RecordedTable {
  std::string text;
  std::string torn;  ///< What was left out at its end, one sentence for a warning; empty: nothing.
};

/// Reads a table of the recording in the folder `session`. A last line without its newline is left out only where the
/// session has no end: half of a number is a number, too, but in a table that somebody made by hand it is a whole one.
[[nodiscard]] Expected<RecordedTable> read_recorded_table(const std::string& path, const std::string& session);

}  // namespace rigcal
