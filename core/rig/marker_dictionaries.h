#pragma once

#include <array>
#include <string_view>

namespace rigcal {

/// A set of square markers (ArUco, AprilTag) by OpenCV's name, in the order of OpenCV's numbers.
struct MarkerDictionary {
  std::string_view name;
  int markers;  ///< In it.
};

inline constexpr std::array<MarkerDictionary, 21> marker_dictionaries{
    {{"DICT_4X4_50", 50},        {"DICT_4X4_100", 100},         {"DICT_4X4_250", 250},
     {"DICT_4X4_1000", 1000},    {"DICT_5X5_50", 50},           {"DICT_5X5_100", 100},
     {"DICT_5X5_250", 250},      {"DICT_5X5_1000", 1000},       {"DICT_6X6_50", 50},
     {"DICT_6X6_100", 100},      {"DICT_6X6_250", 250},         {"DICT_6X6_1000", 1000},
     {"DICT_7X7_50", 50},        {"DICT_7X7_100", 100},         {"DICT_7X7_250", 250},
     {"DICT_7X7_1000", 1000},    {"DICT_ARUCO_ORIGINAL", 1024}, {"DICT_APRILTAG_16h5", 30},
     {"DICT_APRILTAG_25h9", 35}, {"DICT_APRILTAG_36h10", 2320}, {"DICT_APRILTAG_36h11", 587}}};

/// Its number, -1 where there is none of that name.
[[nodiscard]] constexpr int marker_dictionary(std::string_view name) {
  for (std::size_t k = 0; k < marker_dictionaries.size(); ++k) {
    if (marker_dictionaries[k].name == name) return static_cast<int>(k);
  }
  return -1;
}

}  // namespace rigcal
