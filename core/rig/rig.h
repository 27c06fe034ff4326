#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/se3.h"
#include "core/records/lidar_models.h"

namespace rigcal {

enum class ReturnMode { first, strongest, dual, triple };
enum class CoordinateSystem { cartesian, spherical };

/// What the rig file says of a LiDAR. Empty optionals and strings: not said.
struct LidarSettings {
  LidarModel model = LidarModel::other;
  bool rings = false;          ///< The points carry a ring number.
  std::string broadcast_code;  ///< 15 characters, Livox only.
  std::optional<std::array<std::uint8_t, 4>> ip;
  std::optional<ReturnMode> return_mode;
  std::optional<CoordinateSystem> coordinates;
  std::optional<bool> imu;
  std::string scan_pattern;                      ///< "non_repetitive", "repetitive" or empty.
  std::optional<std::array<double, 2>> range_m;  ///< Points outside are not used.
  std::string topic;
  std::string imu_topic;
};

enum class DistortionModel { radtan, equidistant };

/// Pixel (0, 0) is the centre of the top left pixel. radtan: k1 k2 p1 p2 k3 (OpenCV's order); equidistant: k1 .. k4.
struct CameraIntrinsics {
  DistortionModel model = DistortionModel::radtan;
  int width = 0;
  int height = 0;
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
  std::vector<double> distortion;
};

struct TriggerSettings {
  std::string source;
  std::string activation = "rising";
  double delay_us = 0.0;
};

struct CameraSettings {
  std::string driver;  ///< aravis, v4l2 or images.
  std::string device;
  std::string pixel_format;
  std::optional<double> exposure_us;
  std::optional<double> gain;
  std::optional<double> frame_rate;
  std::optional<int> packet_size;
  std::optional<int> packet_delay;
  std::optional<bool> ptp;
  std::optional<std::string> strobe;
  std::optional<TriggerSettings> trigger;
  std::optional<CameraIntrinsics> intrinsics;
  std::string topic;
};

struct Sensor {
  std::string name;
  std::string folder;                  ///< Folder in a patch folder; empty: the name.
  std::optional<LidarSettings> lidar;  ///< Exactly one of `lidar` and `camera` is set.
  std::optional<CameraSettings> camera;
  std::optional<SE3> initial_T_base_sensor;
  [[nodiscard]] bool is_lidar() const { return lidar.has_value(); }
  [[nodiscard]] bool is_livox() const { return lidar && facts_of(lidar->model).is_livox(); }
};

struct TurntableSettings {
  std::string driver = "manual";
  std::optional<Vector3d> axis;  ///< Unit vector in the base frame, right-handed.
  std::string port;              ///< Of a table on a serial line, like all that follows.
  std::optional<int> baud;
  std::string protocol;                        ///< grbl or ascii; empty: grbl.
  bool is_reversed = false;                    ///< Its angles run against the right-hand rule about the axis.
  std::string letter;                          ///< grbl: the axis that turns the table.
  std::optional<double> speed_deg_s;           ///< grbl.
  std::string move, ask, answer, done, fault;  ///< ascii: its lines; empty: the usual ones, "none": there is none.
};

struct TriggerLineSettings {
  std::string gpiochip;
  std::optional<int> line;
  double pulse_us = 1000.0;
  std::optional<int> strobe_line;
  std::string pps;
};

struct NetworkSettings {
  std::string interface = "auto";
  std::string host_ip = "auto";
  bool send_utc = false;  ///< Tell LiDARs that have a PPS the time of day.
};

/// Longer and shorter sides of a square are no lengths in metres.
inline constexpr double largest_square_m = 1.0;
inline constexpr double smallest_square_m = 1e-3;
[[nodiscard]] inline bool can_be_metres(double square) {
  return square >= smallest_square_m && square <= largest_square_m;
}

struct BoardSettings {
  std::string type = "checkerboard";  ///< Or "charuco".
  std::array<int, 2> inner_corners{};
  double square = 0.0;
  std::array<double, 2> size{};
  std::array<double, 2> offset{};
  std::string dictionary{};  ///< Of a ChArUco board's markers, see marker_dictionaries; else empty.
  double marker = 0.0;       ///< Length of a marker's side, in the unit of `square`.
};

/// 4 numbers for equidistant, 5 for radtan.
[[nodiscard]] constexpr std::size_t distortion_count(DistortionModel model) {
  return model == DistortionModel::radtan ? 5 : 4;
}

/// A rig file as it was read; the order of `sensors` is the order in the file and gives every sensor its index.
struct Rig {
  std::string name;
  int base = 0;  ///< Index of the base sensor.
  std::vector<Sensor> sensors;
  std::optional<TurntableSettings> turntable;
  std::optional<TriggerLineSettings> trigger;
  NetworkSettings network;
  std::optional<BoardSettings> board;

  [[nodiscard]] const Sensor& base_sensor() const { return sensors[static_cast<std::size_t>(base)]; }
  /// Index of the sensor of that name, or -1.
  [[nodiscard]] int find(const std::string& sensor_name) const;
};

/// Reads and checks a rig file (docs/manual.md). Every error names "file:line" and the mend: unknown keys (with the
/// nearest known one), values of the wrong kind or out of range, references to sensors that do not exist, a missing
/// base.
[[nodiscard]] Expected<Rig> load_rig(const std::string& path);
/// The same from text; `name` stands for the file in errors.
[[nodiscard]] Expected<Rig> parse_rig(const std::string& text, const std::string& name);
/// A rig file that reads back to the same rig (rotations to the last bit or two).
[[nodiscard]] std::string write_rig(const Rig& rig);

/// Four dotted numbers, or nothing.
[[nodiscard]] std::optional<std::array<std::uint8_t, 4>> parse_ip(std::string_view text);

/// Whether a name can stand for a sensor: 1 to 64 letters, digits, '_', '-' and '.', not a '.' in front. Names become
/// names of folders, so nothing else is safe.
[[nodiscard]] bool is_plain_name(std::string_view name);

}  // namespace rigcal
