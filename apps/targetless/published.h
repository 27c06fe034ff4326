#pragma once

/// Figures as the targetless paper prints them (IEEE TIM 2022), with two LiDARs of real rigs on real scenes, on an
/// Intel i7-9700K. What stands in its plots alone is not here.
namespace rigcal::targetless::published {

// Fig. 10: 100 trials from "10 degrees and 0.2 m".
constexpr double fig10_translation_m = 0.1846;
constexpr double fig10_translation_spread_m = 0.0562;
constexpr double fig10_rotation_deg = 9.40;
constexpr double fig10_rotation_spread_deg = 2.91;
constexpr int fig10_iterations = 5;       ///< All trials of the proposed method have converged then,
constexpr int fig10_icp_iterations = 15;  ///< and the method by ICP slows down then.

// Abstract: LiDAR to LiDAR.
constexpr double lidar_translation_m = 0.008;
constexpr double lidar_rotation_deg = 0.2;

/// Fig. 11, proposed method, in the paper's words; it prints no shares.
[[nodiscard]] inline const char* basin_words(double rotation_deg, double translation_m) {
  if (rotation_deg <= 10.0) return translation_m <= 0.5 ? "converges" : translation_m <= 2.0 ? "mostly" : "fails";
  if (rotation_deg <= 20.0) return translation_m <= 1.0 ? "generally" : translation_m >= 4.0 ? "fails" : "";
  return "";
}

}  // namespace rigcal::targetless::published
