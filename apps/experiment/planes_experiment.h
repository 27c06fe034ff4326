#pragma once

#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

/// Mean and standard deviation of errors over trials.
struct ErrorFigures {
  double rotation_rad = 0.0;
  double rotation_stddev_rad = 0.0;
  double translation_m = 0.0;
  double translation_stddev_m = 0.0;
};

/// One row of the planes paper's Table II, repeated.
struct CornerRow {
  int configuration = 1;
  int angle_deg = 90;
  bool shared_noise = false;
  ErrorFigures paper;
  ErrorFigures published;    ///< The published method, as built here.
  ErrorFigures found;        ///< What `calibrate --method planes` does.
  ErrorFigures informed;     ///< An estimator that is told which point lies on which plane.
  int published_failed = 0;  ///< Trials without an answer; they are in none of the figures of `published`,
  int failed = 0;            ///< or of `found`.
};

/// Corners in which the second LiDAR is turned any way. What is asked for is what is right: half a degree and 5 cm.
struct MountingFigures {
  int trials = 0;
  int right = 0;
  int good = 0;           ///< Called good.
  int weak = 0;           ///< Called weak.
  int wrong_good = 0;     ///< Called good and not right.
  int right_flagged = 0;  ///< Right and not called good.
  double median_s = 0.0;  ///< Time of one calibration, while as many are tried as there are threads.
  double worst_s = 0.0;
};

/// Table II: both configurations, all angles, noise shared by both clouds, then independent. Trial k has the seed
/// `seed` + k in every row. Errors: cancelled.
[[nodiscard]] Expected<std::vector<CornerRow>> repeat_table(int trials, std::uint64_t seed, const RunContext& context);

/// Corners of 60 to 120 degrees (none within 6 degrees of a right angle, where three orders of the planes fit), points
/// of 2 cm noise, stray points, any mounting, no guess.
[[nodiscard]] Expected<MountingFigures> try_mountings(int trials, std::uint64_t seed, const RunContext& context);

/// Two walls and a floor at right angles, seen by LiDARs whose fields are 100 x 60 and 90 x 60 degrees, turned by up to
/// half a radian upwards and sideways and 0.9 about z, points of 2 cm noise; `with_guess`: one that is 45 degrees
/// wrong.
[[nodiscard]] Expected<MountingFigures> try_right_angles(int trials, bool with_guess, std::uint64_t seed,
                                                         const RunContext& context);

}  // namespace rigcal
