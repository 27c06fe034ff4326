#include "core/camera/edge_index.h"

namespace rigcal {

EdgeIndex::EdgeIndex(int width, int height, const std::vector<ImageEdge>& edges)
    : columns_((width + square_px - 1) / square_px), rows_((height + square_px - 1) / square_px) {
  const auto place = [&](const ImageEdge& edge) {
    const int x = std::clamp(square(static_cast<double>(edge.position.x())), 0, columns_ - 1);
    const int y = std::clamp(square(static_cast<double>(edge.position.y())), 0, rows_ - 1);
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
  };
  starts_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const ImageEdge& edge : edges) ++starts_[place(edge) + 1];
  for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
  std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
  edges_.resize(edges.size());
  for (const ImageEdge& edge : edges) edges_[next[place(edge)]++] = edge;
}

}  // namespace rigcal
