#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/recording/batch_source.h"
#include "apps/recording/datagram_file.h"
#include "core/base/run_context.h"
#include "core/pipeline/lidar_calibration.h"
#include "core/rig/rig_file.h"
#include "core/stops/stop_finder.h"

namespace rigcal {

/// A recording in the order of time (a dump, a bag, a session with packets), and the rig that made it; or patches.
struct StreamSource {
  std::string path;  ///< As given.
  std::string file;  ///< The same, or the session's lidar.pcapng or patches/.
  std::string rig_path;
  Rig rig;
  std::string rig_text;  ///< What the rig file holds.
  bool complete = true;  ///< False for a session that was cut short.
};

/// The rig file of a folder that is no session: `given`, else the folder's own rig.yaml. Errors: neither is there; then
/// the folder may also be a result.
[[nodiscard]] Expected<std::string> rig_file_of_folder(const std::string& folder, const std::string& given);

/// Opens a file (then `rig_path` is needed), a session or a patch folder (then it is taken instead of their own
/// rig.yaml where it is not empty). `known`: what is in that file, where it was read already. Patches are not for
/// `read_stops`: `file` is a folder then. Errors: no rig, what `load_rig` and `open_session` find.
[[nodiscard]] Expected<StreamSource> open_stream(const std::string& path, const std::string& rig_path,
                                                 const std::optional<RigFile>& known = {});

/// Packets and bags are cut into stops by what LiDARs saw: of a rig that has none, why nothing comes of them.
[[nodiscard]] std::optional<Error> no_lidar_error(const StreamSource& source);

/// Where the patches of a recording go.
class StopSink : public PatchSink {
 public:
  /// Called before the first point, and again when the recording must be read anew: forget all that came.
  virtual Expected<void> restart() = 0;
  /// An image of a camera, whenever it was taken.
  virtual void image(const RecordedImage& /*image*/) {}
  /// An Error ends the reading.
  [[nodiscard]] virtual Expected<void> status() const = 0;
};

/// For who wants to know of the stops alone.
class NoPoints final : public StopSink {
 public:
  Expected<void> restart() override { return {}; }
  [[nodiscard]] Expected<void> status() const override { return {}; }
  void points(int, int, std::span<const Point>) override {}
  void stop_done(const StopRecord&) override {}
};

/// What was found in a recording beside the points themselves.
struct StopReading {
  IngestSummary ingest;
  StopSource source = StopSource::gyro;  ///< What the stops were found from.
  StillFigures gyro;
  PointStillFigures view;  ///< What the points told.
  PointCounts points;
  std::string truncation;  ///< Where and why the file ended too soon or has a hole; empty otherwise.
  FileNotes notes;
  std::vector<StopRecord> stops;
};

/// Reads the recording once, in its own order, and hands the points of its stops to `sink`. It is read again where a
/// device says too late who it is, where the base's inertial unit keeps silent while another one speaks, and, to find
/// the stops from the points alone, where no unit speaks or the one that does never rests. Errors: an unreadable file,
/// what the sink says, cancelled; whether what was found is enough for a calibration is asked apart (`reading_error`).
[[nodiscard]] Expected<StopReading> read_stops(const StreamSource& source, const StopOptions& options, StopSink& sink,
                                               const RunContext& context);

/// The rotation from the stop before in the base's axes, where it is known: a unit in another sensor turns about its
/// own axes, which the rig file's rough extrinsics carry over.
[[nodiscard]] std::optional<Matrix3d> base_rotation(const Rig& rig, const StillStop& stop);

/// By how much the rig turned since the stop before, about whatever axis, where it is known.
[[nodiscard]] std::optional<double> turned_rad(const StillStop& stop);
/// The same with its axis, as the gyro told it; nothing where the gyro is none of these LiDARs'.
[[nodiscard]] std::optional<GyroTurn> gyro_turn(const std::vector<int>& lidar_sensors, const StillStop& stop);

/// What keeps a recording from being calibrated: nothing of a LiDAR in it, a LiDAR of the rig that is not in it, a rig
/// that never stands still, or, without an inertial unit, LiDARs that see too little to tell.
[[nodiscard]] std::optional<Error> reading_error(const StreamSource& source, const StopOptions& options,
                                                 const StopReading& summary);

/// Why there are stops, and no point in them that could be used. `too_far`: points that lie farther than cells reach.
[[nodiscard]] Error no_points_error(const StreamSource& source, const StopReading& summary, std::uint64_t too_far);

/// Warns of what the file itself told (frames cut short, a clock set back): ahead of an error that it may be the cause
/// of, where nothing else is told.
void warn_of_file(const StreamSource& source, const StopReading& summary, Reporter& reporter);

/// What a user should know of it, in sentences.
[[nodiscard]] std::vector<std::string> reading_warnings(const StreamSource& source, const StopReading& summary);

}  // namespace rigcal
