#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/geometry/se3.h"

/// What a result shows beside its numbers, so that a person can judge it.
namespace rigcal {

/// What a sensor saw in stops that were held out, with its extrinsics from the other stops.
struct HoldOutFigures {
  double ratio = 0.0;      ///< Root mean square over what noise explains: 1 is right. 0: nothing could be held out.
  double rms = 0.0;        ///< In `unit`.
  double start_rms = 0.0;  ///< The same at the guess; 0: there was none.
  std::string unit = "m";  ///< Or "px", of images.
};

/// A direction of a sensor's place, or an axis that it may be turned about, which is known worse than was asked for.
struct WeakDirection {
  bool is_turn = false;
  Vector3d axis = Vector3d::UnitX();  ///< Unit, in the base frame; its sign means nothing.
  double bound = 0.0;                 ///< 95 %, m along it or rad about it.
  bool is_open = false;               ///< Nothing holds it: half a metre or thirty degrees. There is no transform then.
  /// No surface faces it: the transform has what the start took from shapes, nothing was fitted along it.
  bool is_frozen = false;
  std::string missing;  ///< What would hold it: "a level surface (a floor, a ceiling, a table)".
};

/// How thick the surfaces are that two sensors see: by how much the one's points stand off the other's.
struct SharedSurfaces {
  std::string first;  ///< Sensors by name; both empty: all pairs together.
  std::string second;
  std::size_t surfaces = 0;
  double before_m = 0.0;  ///< Root mean square at the guess,
  double after_m = 0.0;   ///< and at the result.
};

/// A surface cut open: the points near a line across it, before and after.
struct SurfaceCut {
  struct Dot {
    float along_m = 0.0F;
    float off_m = 0.0F;       ///< Along the surface's normal.
    std::uint8_t sensor = 0;  ///< Index in the result's sensors.
  };
  Vector3d center_G = Vector3d::Zero();
  Vector3d normal_G = Vector3d::UnitZ();
  double half_length_m = 0.0;
  double half_depth_m = 0.0;
  std::vector<Dot> before;
  std::vector<Dot> after;
};

/// Packets by the name of the sensor and what became of them: "point_" and "imu_" expected, received, lost, gaps,
/// longest_gap_ms and more, for example packets["avia"]["point_lost"].
using PacketCounters = std::map<std::string, std::map<std::string, std::uint64_t>>;

/// How a device's clock was mapped to the session's.
struct ClockReport {
  std::string sensor;
  double drift_ppm = 0.0;  ///< Positive: the device's clock runs fast.
  double jitter_us = 0.0;  ///< Standard deviation of what its packets were late by.
  double max_delay_us = 0.0;
  std::uint64_t jumps = 0;   ///< Times it was set or started anew.
  std::uint64_t strays = 0;  ///< Packets whose stamps make no sense.
};

/// A file, or a folder with all files below it, that a result was made from.
struct InputDigest {
  std::string path;
  std::size_t files = 1;  ///< Of a folder: how many. Its digest is that of the list that sha256sum prints of them.
  std::uint64_t bytes = 0;
  std::string sha256;
  bool in_part = false;  ///< Larger files than the limit: of the size, the first and the last bytes only.
};

}  // namespace rigcal
