#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/se3.h"

namespace rigcal {

/// A line of a TUM trajectory: stamp_s tx ty tz qx qy qz qw. The stamp keeps all its digits: 1 s = 1e9.
struct TumPose {
  std::int64_t stamp_ns = 0;
  SE3 pose;
  int line = 0;  ///< In the file it was read from, for errors.
};

/// Reads a TUM trajectory; lines that begin with '#' are remarks. Errors name "file:line": not eight numbers, a
/// quaternion whose length is off by more than 1 % (shorter slips are made right).
[[nodiscard]] Expected<std::vector<TumPose>> read_tum(const std::string& path);
[[nodiscard]] Expected<std::vector<TumPose>> parse_tum(const std::string& text, const std::string& name);

/// Seconds with nine decimals, from an integer: a double would keep only some hundred nanoseconds of a UTC time.
[[nodiscard]] std::string tum_stamp(std::int64_t stamp_ns);
/// A line of such a file with its end, whatever it is numbered by.
[[nodiscard]] std::string tum_line(std::string_view stamp, const SE3& pose);

/// Replaces a TUM file: stamps with nine decimals, poses with all digits of a double. `remark` becomes a first line
/// '# remark' where it is not empty.
Expected<void> write_tum(const std::string& path, std::span<const TumPose> poses, const std::string& remark = {});

}  // namespace rigcal
