#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "core/board/board_model.h"
#include "core/edges/image_edges.h"
#include "core/records/image.h"
#include "core/rig/camera_model.h"

namespace rigcal {

/// Boards before a grey wall, nine rays a pixel; the square next to the first inner corner is dark. Poses are in the
/// camera's frame.
inline GreyImage board_picture(const CameraModel& camera, const std::vector<SE3>& boards, const BoardModel& board) {
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
          const int colour = board.colour_at(p.x(), p.y(), 0.0);
          grey = colour == 1 ? 30.0 : 220.0;
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
