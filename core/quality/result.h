#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/camera/camera_calibration.h"
#include "core/quality/result_evidence.h"
#include "core/records/records.h"
#include "core/voxel/noise_model.h"

namespace rigcal {

enum class Status { good, weak, failed };

[[nodiscard]] const char* to_string(Status status);

/// By how much a LiDAR measures ranges too far, as the planes show it; its points are as far from the truth.
struct RangeOffset {
  double value_m = 0.0;
  double sigma_m = 0.0;
};

/// By how much the place and the turn of a sensor hang on where the voxels of the map end: how far what one grid gave
/// stands off the solution over several.
struct GridShift {
  double translation_m = 0.0;
  double rotation_rad = 0.0;
};

/// What was found for one sensor. A failed sensor has no transform.
struct SensorResult {
  std::string name;
  Status status = Status::failed;
  std::vector<std::string> reasons;  ///< Why not good, in words a user can act on; empty when good.
  std::optional<SE3> T_base_sensor;
  /// Covariance of xi = [rotation rad; translation m] in T exp(xi), along the sensor's own axes. Zero for the base.
  Matrix6d covariance = Matrix6d::Zero();
  std::optional<SE3> guess_T_base_sensor = std::nullopt;  ///< Where it was thought to be before.
  HoldOutFigures hold_out = {};
  /// Where one stood out: the transform is that without it. Of all ranges; where there is a dark one, of white
  /// surfaces,
  std::optional<RangeOffset> range_offset = std::nullopt;
  std::optional<RangeOffset> dark_offset = std::nullopt;  ///< and of black ones by this more (Cell::darkness).
  std::vector<WeakDirection> weak_directions = {};        ///< Places, then turns, the worst first; empty when good.
  std::optional<NoiseModel> noise = std::nullopt;         ///< Of a LiDAR, as the data told it.
  std::optional<GridShift> grid_shift = std::nullopt;
};

/// An image that took part.
struct UsedImage {
  int stop = 0;      ///< Index into CalibrationResult::trajectory.
  std::string file;  ///< Where it came from; of several of a stop the first.
};

/// What the images told of one camera; its entry in `sensors` has the verdict.
struct CameraEvidence {
  std::string name;
  std::optional<SE3> guess_T_base_camera;
  CameraIntrinsics given;  ///< The rig file's; without a width where it has none.
  bool refined_intrinsics = false;
  std::vector<UsedImage> images;
  CameraEstimate estimate;
};

/// The pose of the rig at one stop.
struct StopPose {
  Stop stop;
  SE3 T_G_base;
  bool known = true;                                 ///< False: the data do not fix this pose.
  bool took_part = false;                            ///< Though it is not known: methods that ask for no poses.
  std::map<std::string, std::uint64_t> points = {};  ///< By the name of the sensor; those without any are left out.

  [[nodiscard]] bool is_used() const { return known || took_part; }
};

/// One stage of the calibration for report.json. `counts` are named figures, for example {"cells", 451000}.
struct StageReport {
  std::string name;
  double wall_s = 0.0;
  int iterations = 0;
  std::optional<double> cost_before;
  std::optional<double> cost_after;
  /// Before the first iteration and after each, one list a map of planes: costs of two maps do not compare.
  std::vector<std::vector<double>> costs;
  std::vector<std::pair<std::string, double>> counts;
  double peak_memory_mb = 0.0;
};

/// A point of the fused cloud in the world frame G with the index in `sensors` of the one that saw it.
struct MapPoint {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
  std::uint8_t reflectivity = 0;
  std::uint8_t sensor = 0;
};

enum class OverlayKind { edges, map };

/// A camera's image with the LiDARs' edges, or the map, drawn into it.
struct Overlay {
  std::string sensor;
  int stop = 0;  ///< Index into CalibrationResult::trajectory.
  OverlayKind kind = OverlayKind::edges;
  std::vector<std::uint8_t> jpeg;
};

/// All that `calibrate` found; `core/report` writes it as a result folder.
struct CalibrationResult {
  std::string base;
  std::string method;
  Status status = Status::failed;     ///< The worst of the sensors.
  bool is_judged = true;              ///< False: transforms of which nobody says how good they are, as a rig file's.
  std::vector<SensorResult> sensors;  ///< In the order of the rig file, the base included.
  std::vector<StopPose> trajectory;
  std::vector<StageReport> stages;
  std::vector<std::string> warnings;
  PacketCounters packets;  ///< Empty where the recording has none.
  std::vector<ClockReport> clocks;
  std::vector<InputDigest> inputs;
  std::vector<std::pair<std::string, std::string>> settings;  ///< Options of the run and what they were.
  std::vector<SharedSurfaces> shared_surfaces;                ///< All pairs, then all together; empty: none is shared.
  std::vector<SurfaceCut> cuts;
  std::vector<MapPoint> map;
  std::vector<std::array<std::uint8_t, 3>> map_rgb;  ///< Of each point of `map`; empty: no camera was found.
  std::vector<MapPoint> map_at_guess;                ///< A point per 5 cm, with the poses of the result.
  std::vector<Overlay> overlays;
  std::vector<CameraEvidence> cameras;  ///< Those that had images and intrinsics, in the order of the rig file.
  std::vector<LidarEdge> edges;         ///< What the cameras were found by; empty where none was.
};

}  // namespace rigcal
