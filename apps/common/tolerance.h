#pragma once

#include <string>

#include "core/base/error.h"

namespace rigcal {

/// A bound on an extrinsic, as `--require` and `--max-error` take it.
struct Tolerance {
  double translation_m = 0.0;
  double rotation_rad = 0.0;
};

/// Reads "10mm,0.1deg": a length in mm, cm or m and an angle in deg or rad, in this order, both positive.
[[nodiscard]] Expected<Tolerance> parse_tolerance(const std::string& text);

/// The same of a distance that sensors have, which may be none: zero is taken.
[[nodiscard]] Expected<Tolerance> parse_distance(const std::string& text);

/// `parse_tolerance` as a check for CLI11: an empty text when right, else what is wrong.
[[nodiscard]] std::string check_tolerance(const std::string& text);

}  // namespace rigcal
