#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/records/records.h"

namespace rigcal {

struct StopTruth {
  Stop stop;
  SE3 T_G_base;
};

/// The turntable's axis in the base frame: a point on it (metres) and its unit direction, right-handed.
struct TableAxis {
  Vector3d point = Vector3d::Zero();
  Vector3d direction = Vector3d::UnitZ();
};

/// Device time = session time + offset + drift * (session time - start of the session).
struct ClockTruth {
  std::int64_t offset_ns = 0;
  double drift_ppm = 0.0;
};

/// What a simulated session knows of itself: ground_truth.yaml.
struct GroundTruth {
  std::string base;
  std::vector<std::pair<std::string, SE3>> T_base_sensor;  ///< In the rig's order, the base (identity) included.
  std::vector<StopTruth> stops;
  std::optional<TableAxis> table_axis;
  /// Named figures by sensor with the unit in the name, for example noise["avia"]["range_m"] = 0.02.
  std::map<std::string, std::map<std::string, double>> noise;
  std::map<std::string, std::map<std::string, double>> biases;
  std::map<std::string, ClockTruth> clocks;  ///< By sensor.
  /// What each sensor sent and what became of it on the way, for example packets["avia"]["point_lost"] = 120.
  std::map<std::string, std::map<std::string, double>> packets;
};

/// Reads a ground_truth.yaml; every error names "file:line". Keys that this release does not know are left alone.
[[nodiscard]] Expected<GroundTruth> load_ground_truth(const std::string& path);
[[nodiscard]] Expected<GroundTruth> parse_ground_truth(const std::string& text, const std::string& name);

/// Replaces a ground_truth.yaml; numbers are written with all their digits.
Expected<void> write_ground_truth(const std::string& path, const GroundTruth& truth);

}  // namespace rigcal
