#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "core/board/board_model.h"
#include "core/board/markers.h"
#include "core/edges/image_edges.h"
#include "core/records/image.h"
#include "core/rig/camera_model.h"

namespace rigcal {

/// Whether a place of the board is printed dark: its squares, the first one dark, and markers in the bright ones.
/// `old`: colours the other way round, as boards with markers were before OpenCV 4.6 where their rows of squares are
/// even.
inline bool is_dark(const BoardModel& board, const std::vector<MarkerCells>& markers, bool old, double x, double y) {
  const int colour = board.colour_at(x, y, 0.0);
  if (colour == 0 || markers.empty()) return colour == 1;
  if (colour == (old ? -1 : 1)) return true;
  const Vector3d first = board.lattice(-1.0, -1.0);
  const int column = static_cast<int>((x - first.x()) / board.square());
  const int row = static_cast<int>((y - first.y()) / board.square());
  int id = 0;
  for (int k = 0; k < row * (board.columns() + 1) + column; ++k) {
    const int parity = k / (board.columns() + 1) + k % (board.columns() + 1);
    id += parity % 2 == (old ? 0 : 1) ? 1 : 0;
  }
  const MarkerCells& marker = markers[static_cast<std::size_t>(id)];
  const double margin = 0.5 * (board.square() - board.marker());
  const double cell = board.marker() / marker.side;
  const int across = static_cast<int>(std::floor((x - first.x() - column * board.square() - margin) / cell));
  const int down = static_cast<int>(std::floor((y - first.y() - row * board.square() - margin) / cell));
  if (across < 0 || down < 0 || across >= marker.side || down >= marker.side) return false;
  return marker.dark[static_cast<std::size_t>(down * marker.side + across)] != 0;
}

/// Boards before a grey wall, nine rays a pixel; the square next to the first inner corner is dark. Poses are in the
/// camera's frame. `old`: see is_dark.
inline GreyImage board_picture(const CameraModel& camera, const std::vector<SE3>& boards, const BoardModel& board,
                               bool old = false) {
  std::vector<MarkerCells> markers;
  for (int id = 0; board.has_markers() && 2 * id < (board.columns() + 1) * (board.rows() + 1); ++id) {
    markers.push_back(marker_cells(board.dictionary(), id).value_or(MarkerCells{1, {0}}));
  }
  const int width = camera.intrinsics().width;
  const int height = camera.intrinsics().height;
  GreyImage out{width, height, std::vector<float>(static_cast<std::size_t>(width * height), 120.0F)};
  Random random(1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0.0;
      const auto middle = camera.ray({x, y});
      const auto right = camera.ray({x + 1.0, y});
      const auto below = camera.ray({x, y + 1.0});
      for (int k = 0; k < 9; ++k) {
        std::optional<Vector3d> ray;
        if (middle && right && below) {
          ray = *middle + (*right - *middle) * ((k % 3 - 1) / 3.0) + (*below - *middle) * ((k / 3 - 1) / 3.0);
        }
        double grey = 120.0;
        for (const SE3& T : boards) {
          if (!ray) break;
          const double along = T.R.col(2).dot(*ray);
          if (std::abs(along) < 1e-6) continue;
          const Vector3d p = T.inverse() * Vector3d(*ray * (T.R.col(2).dot(T.t) / along));
          if (std::abs(p.x()) > 0.5 * board.size().x() || std::abs(p.y()) > 0.5 * board.size().y()) continue;
          grey = is_dark(board, markers, old, p.x(), p.y()) ? 30.0 : 220.0;
        }
        sum += grey / 9.0;
      }
      out.values[static_cast<std::size_t>(y * width + x)] = static_cast<float>(sum + 1.5 * random.normal());
    }
  }
  return out;
}

/// The same as bytes.
inline Image as_image(const GreyImage& grey) {
  Image out;
  out.width = grey.width;
  out.height = grey.height;
  out.pixel_format = "Mono8";
  for (const float value : grey.values) {
    out.bytes.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)));
  }
  return out;
}

}  // namespace rigcal
