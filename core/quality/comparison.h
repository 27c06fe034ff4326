#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/quality/result.h"

namespace rigcal {

enum class MoveVerdict { same, moved, not_compared };

/// One sensor in two results.
struct SensorMove {
  std::string name;
  MoveVerdict verdict = MoveVerdict::not_compared;
  std::string why_not;             ///< Of one that is not compared, in words.
  Vector6d xi = Vector6d::Zero();  ///< log(T_a^-1 T_b) = [rotation rad; translation m], along the sensor's own axes.
  double sigmas = 0.0;             ///< Its length over what both results are sure of: 1 is usual where nothing moved.
};

struct ResultComparison {
  std::string base;                 ///< From which both are told.
  std::vector<std::string> bases;   ///< Their own, where these are two.
  std::vector<SensorMove> sensors;  ///< All but the base: those of `a` in its order, then those that only `b` has.
  /// All others moved in one and the same way: then the base moved, and they did not.
  bool base_moved = false;
};

/// Compares the extrinsics of two results by their joint sigma: moved is what one in a thousand differs by where
/// nothing moved. What a unit has wrong in the same way in both recordings cancels, though its
/// ranges' share is in sigma. Where the
/// results have two bases both are told from a sensor that both have: the first one's base, else the second one's, else
/// the first that can be; sigma is then that of both sensors, which takes them for independent. Error: no such sensor.
[[nodiscard]] Expected<ResultComparison> compare_results(const CalibrationResult& first,
                                                         const CalibrationResult& second);

/// In one sentence: "Nothing moved: 3 sensors are where they were." or "mid100_left moved by 5.1 mm and 0.012 degrees
/// (16 times what both results are sure of); 2 others are where they were."
[[nodiscard]] std::string comparison_sentence(const ResultComparison& comparison);

}  // namespace rigcal
