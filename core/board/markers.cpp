#include "core/board/markers.h"

#include <algorithm>

#include "core/board/image_bytes.h"
#include "core/rig/marker_dictionaries.h"

#ifdef RIGCAL_HAS_ARUCO
#include <opencv2/core/version.hpp>
// The module moved from contrib to objdetect with OpenCV 4.7, and calls changed.
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
#define RIGCAL_ARUCO_IN_OBJDETECT
#include <opencv2/objdetect/aruco_detector.hpp>
#else
#include <opencv2/aruco.hpp>
#endif
#endif

namespace rigcal {

#ifdef RIGCAL_HAS_ARUCO

static_assert(cv::aruco::DICT_APRILTAG_36h11 + 1 == static_cast<int>(marker_dictionaries.size()));

bool knows_markers() { return true; }

std::vector<ImageMarker> find_markers(const GreyImage& grey, int dictionary) {
  const cv::Mat image = bytes_of(grey);
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  try {
#ifdef RIGCAL_ARUCO_IN_OBJDETECT
    const cv::aruco::ArucoDetector detector(cv::aruco::getPredefinedDictionary(dictionary));
    detector.detectMarkers(image, corners, ids);
#else
    cv::aruco::detectMarkers(image, cv::aruco::getPredefinedDictionary(dictionary), corners, ids);
#endif
  } catch (const cv::Exception&) {
    return {};  // images of a few pixels
  }
  std::vector<ImageMarker> out;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    ImageMarker& marker = out.emplace_back();
    marker.id = ids[k];
    for (std::size_t c = 0; c < 4; ++c) marker.corners[c] = {corners[k][c].x, corners[k][c].y};
  }
  std::stable_sort(out.begin(), out.end(), [](const ImageMarker& a, const ImageMarker& b) { return a.id < b.id; });
  return out;
}

std::optional<MarkerCells> marker_cells(int dictionary, int id) {
  if (dictionary < 0 || dictionary >= static_cast<int>(marker_dictionaries.size()) || id < 0 ||
      id >= marker_dictionaries[static_cast<std::size_t>(dictionary)].markers) {
    return std::nullopt;
  }
  const auto markers = cv::aruco::getPredefinedDictionary(dictionary);
  MarkerCells out;
  cv::Mat picture;
#ifdef RIGCAL_ARUCO_IN_OBJDETECT
  out.side = markers.markerSize + 2;
  markers.generateImageMarker(id, out.side, picture, 1);
#else
  out.side = markers->markerSize + 2;
  markers->drawMarker(id, out.side, picture, 1);
#endif
  for (int row = 0; row < out.side; ++row) {
    for (int column = 0; column < out.side; ++column) {
      out.dark.push_back(picture.at<std::uint8_t>(row, column) < 128 ? 1 : 0);
    }
  }
  return out;
}

#else

bool knows_markers() { return false; }
std::vector<ImageMarker> find_markers(const GreyImage&, int) { return {}; }
std::optional<MarkerCells> marker_cells(int, int) { return std::nullopt; }

#endif

}  // namespace rigcal
