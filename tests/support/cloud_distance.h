#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nanoflann.hpp>
#include <vector>

#include "core/geometry/se3.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {

/// Points for nanoflann.
struct CloudAdaptor {
  const std::vector<Vector3d>& points;
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t d) const { return points[i][static_cast<long>(d)]; }
  template <class B>
  bool kdtree_get_bbox(B&) const {
    return false;
  }
};

/// Distances of the points of `a` to the planes through their 20 nearest in `b`, metres: for points whose 10th nearest
/// is within 0.3 m, where that plane's rms is below 0.03 m and the distance below 0.15 m.
inline std::vector<double> point_to_plane_distances(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b,
                                                    std::size_t every) {
  const CloudAdaptor adaptor{b};
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, CloudAdaptor>, CloudAdaptor, 3,
                                                   std::uint32_t>;
  const Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  std::vector<double> out;
  constexpr std::size_t k = 20;
  std::vector<std::uint32_t> index(k);
  std::vector<double> squares(k);
  for (std::size_t i = 0; i < a.size(); i += every) {
    if (tree.knnSearch(a[i].data(), k, index.data(), squares.data()) < k || squares[9] > 0.3 * 0.3) continue;
    Vector3d mean = Vector3d::Zero();
    for (const auto n : index) mean += b[n] / k;
    Matrix3d S = Matrix3d::Zero();
    for (const auto n : index) S += (b[n] - mean) * (b[n] - mean).transpose() / k;
    const SymmetricEigen eigen = symmetric_eigen(S);
    const double distance = std::abs(eigen.vectors.col(0).dot(a[i] - mean));
    if (eigen.values[0] < 0.03 * 0.03 && distance < 0.15) out.push_back(distance);
  }
  return out;
}

/// The median of the above, both directions averaged. `every`: use each so manieth point of the one cloud.
inline double median_point_to_plane_m(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b,
                                      std::size_t every = 1) {
  const auto median = [](std::vector<double> v) {
    if (v.empty()) return 1e9;
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end());
    return *middle;
  };
  return 0.5 * (median(point_to_plane_distances(a, b, every)) + median(point_to_plane_distances(b, a, every)));
}

}  // namespace rigcal
