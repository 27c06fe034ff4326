#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/input_file.h"

namespace rigcal {

/// What an .lvx file says of one device.
struct LvxDevice {
  std::string broadcast_code;   ///< Up to 16 printable characters; others are shown as '?'.
  std::uint8_t index = 0;       ///< As the packages name it.
  std::uint8_t type = 0;        ///< Livox device type.
  bool has_extrinsics = false;  ///< The recording program was told to use the six numbers below (1.0: always).
  std::array<float, 3> roll_pitch_yaw_deg{};
  std::array<float, 3> translation_m{};
};

struct LvxCounters {
  std::uint64_t frames = 0;           ///< Whole ones.
  std::uint64_t packages = 0;         ///< Delivered.
  std::uint64_t damaged_frames = 0;   ///< With a package that does not fit: used up to it.
  std::uint64_t unknown_devices = 0;  ///< Packages of devices that the file does not list: left out.
};

/// What a user should know of these counts, in clauses.
[[nodiscard]] std::vector<std::string> lvx_findings(const LvxCounters& counters);

/// One package of a recording.
struct LvxPackage {
  std::size_t device = 0;   ///< Position in `devices()`.
  std::uint64_t frame = 0;  ///< Number of the frame it stands in, from 0.
  ByteView packet;          ///< A sample packet as on the wire; lives until the next call.
};

/// Streams the packages of a Livox .lvx recording, versions 1.0 and 1.1, in their order, one at a time. The packages of
/// version 1.0, whose points are floats in metres, are delivered as the packets of whole millimetres that they were
/// made from. A file that is cut is read up to its last whole frame.
class LvxReader {
 public:
  /// Errors: missing, no permission, no .lvx file, another version, a header that is cut, no devices.
  [[nodiscard]] static Expected<LvxReader> open(const std::string& path);

  /// False at the end: ask `failure` and `truncation` then.
  [[nodiscard]] bool next(LvxPackage& package);

  /// Where and why reading ended before the file did, one clause; empty otherwise.
  [[nodiscard]] const std::string& truncation() const { return truncation_; }
  /// What went wrong when reading ("Input/output error"): then what was read is not all that the file holds.
  [[nodiscard]] const std::string& failure() const { return file_.failure(); }
  [[nodiscard]] const LvxCounters& counters() const { return counters_; }
  [[nodiscard]] const std::vector<LvxDevice>& devices() const { return devices_; }
  /// "1.0" or "1.1".
  [[nodiscard]] const char* version() const { return minor_ == 0 ? "1.0" : "1.1"; }
  /// What a frame lasts.
  [[nodiscard]] std::int64_t frame_ns() const { return frame_ns_; }
  /// Of the next byte in the file, and of the whole file (nothing for a pipe): for progress.
  [[nodiscard]] std::uint64_t offset() const { return file_.offset(); }
  [[nodiscard]] std::optional<std::uint64_t> size() const { return file_.size(); }

 private:
  explicit LvxReader(InputFile file) : file_(std::move(file)) {}
  Expected<void> read_head();
  void read_device(ByteView info);
  bool begin_frame();
  bool read_package(LvxPackage& package);
  bool leave_frame();
  bool end(std::uint64_t offset, const char* reason);

  InputFile file_;
  int minor_ = 1;
  std::int64_t frame_ns_ = 50'000'000;
  std::vector<LvxDevice> devices_;
  std::uint64_t frame_end_ = 0;  ///< Offset in the file.
  bool ended_ = false;
  std::vector<std::uint8_t> packet_;  ///< Of version 1.0.
  std::string truncation_;
  LvxCounters counters_;
};

}  // namespace rigcal
