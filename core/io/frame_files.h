#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/output_file.h"
#include "core/records/image.h"

/// The tables beside a session's packets: frames.csv of each camera, trigger.csv and turntable.csv. Of one with an
/// error, `good_bytes` (may be null) gets where the first line that is wrong begins; of others its whole length.
namespace rigcal {

/// Reads frames.csv: file,stamp_ns,trigger,exposure_us,device_stamp,stop; the last four may be empty. Errors name
/// "file:line": values of the wrong kind or below zero, a file's name that is no plain name, the same file twice.
[[nodiscard]] Expected<std::vector<FrameRecord>> read_frames(const std::string& path);
[[nodiscard]] Expected<std::vector<FrameRecord>> parse_frames(const std::string& text, const std::string& name,
                                                              std::size_t* good_bytes = nullptr);
Expected<void> write_frames(const std::string& path, std::span<const FrameRecord> frames);

/// A frames.csv that grows while images are taken: what was added can be read at any time.
class FrameTable {
 public:
  /// Errors: the disk.
  [[nodiscard]] static Expected<FrameTable> create(const std::string& path);
  Expected<void> add(const FrameRecord& frame);
  Expected<void> close() { return file_.close(); }

 private:
  explicit FrameTable(OutputFile file) : file_(std::move(file)) {}
  OutputFile file_;
};

/// Reads trigger.csv: pulse,stamp_ns; numbers and stamps must both go up from line to line.
[[nodiscard]] Expected<std::vector<TriggerPulse>> read_trigger(const std::string& path);
[[nodiscard]] Expected<std::vector<TriggerPulse>> parse_trigger(const std::string& text, const std::string& name,
                                                                std::size_t* good_bytes = nullptr);
/// A trigger.csv that grows while pulses are given: what was added can be read at any time.
class TriggerTable {
 public:
  /// Errors: the disk.
  [[nodiscard]] static Expected<TriggerTable> create(const std::string& path);
  Expected<void> add(const TriggerPulse& pulse);
  Expected<void> close() { return file_.close(); }

 private:
  explicit TriggerTable(OutputFile file) : file_(std::move(file)) {}
  OutputFile file_;
};

/// Reads turntable.csv: stamp_ns,angle_deg; stamps must go up from line to line.
[[nodiscard]] Expected<std::vector<TableAngle>> read_turntable(const std::string& path);
[[nodiscard]] Expected<std::vector<TableAngle>> parse_turntable(const std::string& text, const std::string& name,
                                                                std::size_t* good_bytes = nullptr);
/// A turntable.csv that grows while the table is asked: what was added can be read at any time.
class TurntableTable {
 public:
  /// Errors: the disk.
  [[nodiscard]] static Expected<TurntableTable> create(const std::string& path);
  Expected<void> add(const TableAngle& angle);
  Expected<void> close() { return file_.close(); }

 private:
  explicit TurntableTable(OutputFile file) : file_(std::move(file)) {}
  OutputFile file_;
};

Expected<void> write_trigger(const std::string& path, std::span<const TriggerPulse> pulses);

}  // namespace rigcal
