#pragma once

#include "core/pipeline/lidar_calibration.h"
#include "core/planes/refine.h"
#include "core/quality/time_halves.h"
#include "core/start/rig_start.h"

namespace rigcal {

/// Where the calibration ended, in the base's frame.
struct LidarSolution {
  /// Nothing is known yet.
  LidarSolution(int stops, int lidars) : layout(stops, lidars) {}

  Start start;
  RigState state;
  ParameterLayout layout;  ///< As it was solved: the LiDAR that is fixed may be another than the base.
  AdjustOptions adjust;    ///< Likewise; poses of its priors in the world of that.
  RefineSummary refined;
  std::vector<ExtrinsicMove> moves_on_one_grid;  ///< Of the pass before those that settle; empty where none had to.
  std::vector<char> use;                         ///< Patches that took part.
  std::vector<NoiseModel> noise;
  std::vector<GridShift> grid_shifts;  ///< Seen from the base; empty where the last solution was over one grid.
  double unevenness_m = 0.0;           ///< What the surfaces are not, beyond noise; 0: planes as good as their noise.
  SE3 T_grid_G;
  RangeCorrection ranges;
  std::vector<PatchCells> corrected;  ///< The recording's patches without these errors.
  /// Along which direction of its own frame each LiDAR stays where shapes laid it; zero: none. Empty: not of any.
  std::vector<Vector3d> frozen;
  /// The LiDAR by whose own gyro all turns were told, where it was solved in its frame: stops are checked against it.
  std::optional<int> gyro_lidar;

  [[nodiscard]] const std::vector<PatchCells>& patches(const LidarRecording& recording) const {
    return corrected.empty() ? recording.patches : corrected;
  }
};

/// Whether a LiDAR that the last pass moved so far has come to rest: by a tenth of what is asked for at most, in turn
/// and in place. Maps built anew shuffle cells between voxels for ever.
[[nodiscard]] bool is_rest(const ExtrinsicMove& move, const Requirement& require);

/// What a calibration begins with instead of a search: where an earlier one of the same recording's first stops ended,
/// with the poses of the stops since, good to a few centimetres.
struct WarmStart {
  Start start;
  std::vector<NoiseModel> noise;
  SE3 T_grid_G;
  std::optional<int> gyro_lidar;  ///< As of the earlier one.
  int stops_before = 0;           ///< Of the earlier one: which of them it left out was told.
};

/// Extrinsics, sigmas and verdicts of a recording that goes on, in a fraction of the time of `calibrate_lidars`: from
/// `warm` where it is not null, else from a search; a few passes of the joint adjustment; no map, no comparison with
/// the guess. Errors and `solution` as there.
[[nodiscard]] Expected<CalibrationResult> estimate_lidars(const Rig& rig, const LidarRecording& recording,
                                                          const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                                                          const LidarCalibrationOptions& options,
                                                          const RunContext& context, const WarmStart* warm,
                                                          std::unique_ptr<LidarSolution>& solution);

/// What tells how far the numbers of a solution can be trusted.
struct SolutionQuality {
  LidarCovariances covariances;  ///< Of the poses in the base's frame.
  HoldOut held_out;
  std::vector<TimeHalves> time_halves;  ///< One for each LiDAR.
};

/// Of a solution where it was solved, in whichever LiDAR's frame that is; the guesses likewise.
[[nodiscard]] SolutionQuality weigh_solution(int base_lidar, const std::vector<std::optional<SE3>>& guess,
                                             const LidarSolution& solution);

/// The verdict on every LiDAR of the rig, and the poses of the stops, of a solution in the base's frame. Everything of
/// the result but stages, warnings and map.
[[nodiscard]] CalibrationResult judge_solution(const Rig& rig, const LidarRecording& recording, int base_lidar,
                                               const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                                               const LidarCalibrationOptions& options, const LidarSolution& solution,
                                               const SolutionQuality& quality);

}  // namespace rigcal
