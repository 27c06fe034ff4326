#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/base/run_context.h"
#include "core/io/patch_folder.h"
#include "core/pipeline/rig_calibration.h"
#include "core/rig/rig.h"

namespace rigcal {

/// A recording as `calibrate` takes it, whatever it was: already cut into patches, points already in cells.
struct Recording {
  Rig rig;
  LidarRecording lidar;
  std::vector<CameraRecording> cameras;  ///< All of the rig's, with guesses from the rig file; read when asked for.
  std::uint64_t points = 0;              ///< In the patches.
  /// Packets by the name of the sensor and what became of them ("point_lost"); empty where it came as patches.
  std::map<std::string, std::map<std::string, std::uint64_t>> packets;
  std::vector<ClockReport> clocks;  ///< Likewise empty.
};

/// Where a recording lies. `rig` may be empty for a session, which has its own; `images` where they lie with the
/// recording, and otherwise is laid out like a session's.
struct RecordingPaths {
  std::string input;
  std::string rig;
  std::string images;
};

/// Reads a packet dump, a session or a patch folder. What is
/// worth telling (losses, a cut dump, unknown folders) goes to the reporter as warnings. Errors as the contract's exit
/// code 3 wants them: nothing there, no Livox packet, a LiDAR of the rig without packets, a rig that never stands
/// still.
[[nodiscard]] Expected<Recording> read_recording(const RecordingPaths& paths, const CellOptions& cells,
                                                 const RunContext& context);

}  // namespace rigcal
