#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/recording/stop_image_cache.h"
#include "apps/recording/table_angles.h"
#include "core/base/run_context.h"
#include "core/io/patch_folder.h"
#include "core/pipeline/rig_calibration.h"
#include "core/rig/rig_file.h"

namespace rigcal {

/// A recording as `calibrate` takes it, whatever it was: already cut into patches, points already in cells.
struct Recording {
  Rig rig;
  LidarRecording lidar;
  std::vector<CameraRecording> cameras;  ///< All of the rig's, with guesses from the rig file; read when asked for.
  std::uint64_t points = 0;              ///< In the patches.
  /// All points near each LiDAR, in the order of the stops, where asked for; Patch::stop counts in `lidar.stops`.
  std::vector<Patch> near_points;
  /// Packets by the name of the sensor and what became of them ("point_lost"); empty where it came as patches.
  std::map<std::string, std::map<std::string, std::uint64_t>> packets;
  std::vector<ClockReport> clocks;  ///< Likewise empty.
  TableTurns table_turns;           ///< What the table said of the turns; empty where it said nothing.
};

/// Where a recording lies, and what is kept of it. `rig` may be empty where a folder has its own; `images` where
/// they lie with the recording, and otherwise is laid out like a session's. `known_rig`: what is in `rig`, where it was
/// read already.
struct RecordingPaths {
  std::string input;
  std::string rig;
  std::string images;
  double keep_points_within_m = 0.0;  ///< How far from each LiDAR all points are kept besides the cells; 0: none.
  std::optional<RigFile> known_rig = {};
};

/// Appends those of the points that are nearer than `within_m` to their sensor.
void add_near_points(std::span<const Point> points, double within_m, std::vector<Point>& out);

/// Error: `paths.images` is no folder.
[[nodiscard]] Expected<void> check_images(const RecordingPaths& paths);
/// Folders in which the images of the rig's cameras may lie, in the order in which they are looked for: in
/// `paths.images`, else with the recording.
[[nodiscard]] std::vector<std::string> image_places(const RecordingPaths& paths);
/// Where the images are, into `recording`. `ahead`: what of them was read before; may be null.
void take_cameras(const RecordingPaths& paths, Recording& recording,
                  const std::shared_ptr<StopImageCache>& ahead = nullptr);

/// Reads a packet dump, a session or a patch folder. What is worth telling (losses, a cut dump, unknown folders) goes
/// to the reporter as warnings. Errors: nothing there, no Livox packet, a LiDAR of the rig without packets, a rig that
/// never stands still.
[[nodiscard]] Expected<Recording> read_recording(const RecordingPaths& paths, const CellOptions& cells,
                                                 const RunContext& context);

/// Tells the turns in the base's frame anew, by these guesses (one for each LiDAR, the base's own included) in place of
/// the rig file's: the gyro may be on another LiDAR than the base. What it told and no guess leads to is left to the
/// table.
void tell_turns_by(const std::vector<std::optional<SE3>>& guess_T_base_sensor, Recording& recording);

}  // namespace rigcal
