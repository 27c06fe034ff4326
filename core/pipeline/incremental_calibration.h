#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/pipeline/lidar_result.h"
#include "core/pipeline/rig_calibration.h"
#include "core/quality/stop_advice.h"

namespace rigcal {

/// What came in with one stop.
struct CalibrationStop {
  Stop stop;
  std::vector<PatchCells> patches;          ///< By LiDAR; which stop they name does not matter.
  std::optional<Matrix3d> R_previous_this;  ///< Of the base, by the gyro.
  std::optional<GyroTurn> gyro_turn;        ///< The same as it was told.
  std::optional<double> turned_rad;         ///< Likewise, where its axis is not known.
  std::optional<SE3> T_G_base;              ///< Rough, where the recording has a trajectory.
  std::vector<std::uint64_t> too_far;       ///< Of each LiDAR, as in a LidarRecording; empty: not counted.
};

/// How well one LiDAR is known after a stop.
struct LidarEstimate {
  SensorResult result;               ///< Its status is by the goal.
  double translation_bound_m = 0.0;  ///< 95 %; both are 0 for the base and where there is no transform.
  double rotation_bound_rad = 0.0;
  Vector3d weak_translation = Vector3d::Zero();  ///< Unit, base frame: where it is known worst,
  Vector3d weak_rotation = Vector3d::Zero();     ///< and about which axis.
};

/// What is known after a stop.
struct StopEstimate {
  int stops = 0;
  std::vector<LidarEstimate> lidars;  ///< In the order of the rig, the base included.
  bool reached = false;               ///< All of them are good by the goal.
  bool searched = false;              ///< Found by a search from scratch, not from the solution before.
  /// Which stops were left out, and why: of a search all of them, else those since the estimate before.
  std::vector<std::string> warnings;
  std::optional<StopAdvice> advice;
  std::string advice_text;  ///< A sentence; empty without advice.
  double wall_s = 0.0;
};

struct IncrementalOptions {
  LidarCalibrationOptions lidars;
  Requirement goal;  ///< What the estimates are judged by; `lidars.require` is for the final result.
  bool advise = true;
};

/// The targetless method a stop at a time. Cells are made before, once a stop: what a stop costs depends on the
/// surfaces seen so far, not on the points. The final result is that of the batch (`calibrate_rig`), on the same cells
/// and by the same code: the same to the bit.
class IncrementalCalibration {
 public:
  /// `guess_T_base_lidar` has an entry for each of `lidar_sensors`.
  IncrementalCalibration(Rig rig, std::vector<int> lidar_sensors, std::vector<std::optional<SE3>> guess_T_base_lidar,
                         const IncrementalOptions& options);

  /// Keeps a stop without solving; the next `estimate` takes all of them.
  void add_stop(CalibrationStop stop);
  /// Of the stops so far. Starts from the solution before where the new stops can be laid on it (the way there from the
  /// last stop that is known was told by a gyro, a table or a trajectory, or the table's axis is known), from scratch
  /// otherwise: while there are few stops, at each doubling of them (or half as many more, while one failed), when a
  /// LiDAR comes right that had failed, and while one has not been found. Errors: as `calibrate_lidars`; cancelled.
  [[nodiscard]] Expected<StopEstimate> estimate(const RunContext& context);
  /// The batch's result on all stops, and its errors.
  [[nodiscard]] Expected<CalibrationResult> finish(const std::vector<CameraRecording>& cameras,
                                                   const std::optional<CameraCalibrationOptions>& camera_options,
                                                   const RunContext& context) const;

  [[nodiscard]] const LidarRecording& recording() const { return recording_; }
  /// All stops; nothing more is to be asked of this then.
  [[nodiscard]] LidarRecording take_recording() { return std::move(recording_); }
  /// Where the last estimate ended; null before the first.
  [[nodiscard]] const LidarSolution* solution() const { return solution_.get(); }

 private:
  [[nodiscard]] std::optional<WarmStart> warm_start() const;
  [[nodiscard]] bool is_due_anew() const;
  /// Whether one has a transform that had none after the last search.
  [[nodiscard]] bool has_sudden(const std::vector<SensorResult>& sensors) const;
  /// T_G_base of a stop that is not known, by how it stands to the last known one before it; nothing: only a search of
  /// all stops might find it.
  [[nodiscard]] std::optional<SE3> pose_of(std::size_t stop, const Start& start) const;
  /// Of the base from one stop to another, where all turns between them were told.
  [[nodiscard]] std::optional<Matrix3d> turn_between(std::size_t from, std::size_t to, const Start& start) const;
  [[nodiscard]] LidarEstimate one_lidar(const SensorResult& sensor) const;
  void advise(const CalibrationResult& result, StopEstimate& out) const;

  Rig rig_;
  std::vector<std::optional<SE3>> guess_;
  IncrementalOptions options_;
  LidarRecording recording_;
  std::unique_ptr<LidarSolution> solution_;
  int stops_at_search_ = 0;
  std::vector<char> failed_at_search_;  // by sensor of a result
};

/// One more stop of a recording.
void append(CalibrationStop stop, LidarRecording& recording);
/// The stops of a recording, each as it would have come in.
[[nodiscard]] std::vector<CalibrationStop> stops_of(const LidarRecording& recording);

}  // namespace rigcal
