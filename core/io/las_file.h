#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/base/error.h"
#include "core/io/output_file.h"
#include "core/records/records.h"

namespace rigcal {

/// Writes a LAS 1.4 file part by part, point format 1, or 0 where there are no times. Coordinates are whole tenths of a
/// millimetre; intensity is reflectivity * 256; the user data byte is the Livox tag; every point is return 1 of 1; the
/// point source id tells the sensor. Times are adjusted standard GPS time (GPS seconds less 1e9), made from UTC with
/// the 18 leap seconds that hold since 2017. The day of creation is that of the first point, so that the same points
/// make the same file. Counts and bounds are filled in at the end. Specification: ASPRS, LAS 1.4 R15.
class LasWriter {
 public:
  static constexpr double scale_m = 1e-4;

  struct Options {
    std::uint16_t source_id = 0;  ///< 1 to 65535; 0: unknown.
    bool timed = true;
  };

  /// Makes the file, or empties an existing one.
  [[nodiscard]] static Expected<LasWriter> create(const std::string& path, const Options& options);

  /// Point::shot counts from `stamp_ns` (UTC) in steps of `shot_interval_ns`. Points that lie farther than 214 km,
  /// which the format's integers cannot hold at this scale, and those that are not finite are left out.
  void write(std::span<const Point> points, std::int64_t stamp_ns = 0, double shot_interval_ns = 0.0);
  /// Completes the file. The first error of any write is reported here.
  Expected<void> finish();

  [[nodiscard]] std::uint64_t points() const { return points_; }
  [[nodiscard]] std::uint64_t left_out() const { return left_out_; }

 private:
  LasWriter(OutputFile file, const Options& options) : file_(std::move(file)), options_(options) {}
  [[nodiscard]] std::string header() const;

  OutputFile file_;
  Options options_;
  std::uint64_t points_ = 0;
  std::uint64_t left_out_ = 0;
  std::array<std::int32_t, 3> least_{};
  std::array<std::int32_t, 3> most_{};
  std::optional<std::int64_t> first_ns_;
};

}  // namespace rigcal
