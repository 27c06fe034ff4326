#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/geometry/se3.h"

/// The plain structs that cross rooms. Times named stamp_ns are session time (int64 nanoseconds) unless the name says
/// device_stamp_ns.
namespace rigcal {

/// An IPv4 address, bytes in dotted order, and a UDP port.
struct Endpoint {
  std::array<std::uint8_t, 4> ip{};
  std::uint16_t port = 0;
  auto operator<=>(const Endpoint&) const = default;
};

[[nodiscard]] std::string to_string(const std::array<std::uint8_t, 4>& ip);
[[nodiscard]] std::string to_string(const Endpoint& endpoint);

/// One UDP payload as it was sent; `bytes` lives as long as the source says (usually until the next one is asked for).
struct Datagram {
  std::int64_t stamp_ns = 0;
  Endpoint from;
  Endpoint to;
  ByteView bytes;
};

/// One return, metres in the sensor's frame (x forward, y left, z up).
struct Point {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
  std::uint8_t reflectivity = 0;
  std::uint8_t tag = 0;    ///< Livox tag byte; 0 where the data type has none.
  std::uint16_t shot = 0;  ///< Index of the laser shot in its batch: its time is stamp_ns + shot * shot_interval_ns.
};
static_assert(sizeof(Point) == 16);

/// The returns of one packet or message (slots without a return are left out) of one sensor of the rig.
struct PointBatch {
  int sensor = 0;             ///< Index of the sensor in the rig.
  std::int64_t stamp_ns = 0;  ///< Session time of shot 0.
  double shot_interval_ns = 0.0;
  /// Shots fired, with or without a return; 0: not known, as of a cloud, where Point::shot only divides its time.
  std::uint16_t shots = 0;
  /// The points have no times of their own: they came at some moment of the batch, which nobody knows. All of it is one
  /// interval then.
  bool undivided = false;
  std::vector<Point> points;
};

/// One reading of an inertial unit in its sensor's frame.
struct ImuSample {
  int sensor = 0;
  std::int64_t stamp_ns = 0;
  Vector3d gyro_rad_s = Vector3d::Zero();
  Vector3d acceleration_g = Vector3d::Zero();
};

/// An interval in which the rig stands still, ends included, session time.
struct Stop {
  int index = 0;
  std::int64_t start_ns = 0;
  std::int64_t end_ns = 0;
};

/// Position in `stops` of the one that contains all from `start_ns` to `end_ns`.
[[nodiscard]] std::optional<std::size_t> stop_that_contains(std::span<const Stop> stops, std::int64_t start_ns,
                                                            std::int64_t end_ns);

/// What one sensor saw in one stop.
struct Patch {
  int sensor = 0;
  int stop = 0;
  std::vector<Point> points;
};

}  // namespace rigcal
