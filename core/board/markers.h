#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "core/edges/image_edges.h"

namespace rigcal {

/// Whether this program was built with OpenCV's aruco module, by which markers are known.
[[nodiscard]] bool knows_markers();

/// A square marker in an image: its corners clockwise (y down) from its own upper left one.
struct ImageMarker {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;
};

/// All markers of a dictionary (see marker_dictionary) in an image, by id; none where `knows_markers` is false.
[[nodiscard]] std::vector<ImageMarker> find_markers(const GreyImage& grey, int dictionary);

/// What a marker looks like: `side` times `side` cells, row by row, its dark rim among them.
struct MarkerCells {
  int side = 0;
  std::vector<char> dark;
};
/// Nothing for an id that the dictionary does not have, or where `knows_markers` is false.
[[nodiscard]] std::optional<MarkerCells> marker_cells(int dictionary, int id);

}  // namespace rigcal
