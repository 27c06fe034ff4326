#pragma once

#include <array>

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

/// Table I: seconds of one iteration; 0: not printed.
struct StageSeconds {
  const char* method;
  const char* stage;
  double match_s;
  double solve_s;
};
inline constexpr std::array<StageSeconds, 6> table_1{{{"rigcal", "pose", 0.1040, 0.0328},
                                                      {"ICP, all points", "pose", 4.0220, 1.1057},
                                                      {"rigcal", "extrinsic", 0.0, 0.0443},
                                                      {"ICP, all points", "extrinsic", 0.0, 1.6041},
                                                      {"rigcal", "global", 2.2940, 0.4687},
                                                      {"ICP, all points", "global", 11.0557, 3.3616}}};

/// Table II: seconds for the features of all scans, and for one iteration; 0: it has none.
struct CameraSeconds {
  const char* method;
  double planes_s;
  double edges_s;
  double match_s;
  double solve_s;
  int voxels;
};
inline constexpr std::array<CameraSeconds, 3> table_2{{{"rigcal", 3.8054, 2.4494, 0.5424, 0.2510, 1369},
                                                       {"fixed voxels", 9.6186, 27.6738, 0.8609, 0.5552, 9216},
                                                       {"information", 0.0, 0.0, 3.6042, 0.6101, 0}}};

/// Of guesses from "5 degrees and 0.1 m", mean and spread.
struct CameraGuesses {
  double rotation_deg;
  double rotation_spread_deg;
  double translation_m;
  double translation_spread_m;
};
inline constexpr CameraGuesses fig13{2.4768, 1.2390, 0.1308, 0.0682};  ///< AVIA, with overlap.
inline constexpr CameraGuesses fig14{2.5408, 1.3645, 0.1376, 0.0663};  ///< MID-40, without.

// Abstract: LiDAR to camera.
constexpr double camera_translation_m = 0.006;
constexpr double camera_rotation_deg = 0.09;

/// Fig. 11, proposed method, in the paper's words; it prints no shares.
[[nodiscard]] inline const char* basin_words(double rotation_deg, double translation_m) {
  if (rotation_deg <= 10.0) return translation_m <= 0.5 ? "converges" : translation_m <= 2.0 ? "mostly" : "fails";
  if (rotation_deg <= 20.0) return translation_m <= 1.0 ? "generally" : translation_m >= 4.0 ? "fails" : "";
  return "";
}

}  // namespace rigcal::targetless::published
