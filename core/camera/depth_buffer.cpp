#include "core/camera/depth_buffer.h"

#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

// A surface that fills the view would be splatted over everything; beyond this it is near enough to be dense anyway.
constexpr int max_splat_cells = 12;

}  // namespace

DepthBuffer::DepthBuffer(const CameraModel& model, const SE3& T_C_G, std::span<const MapSample> samples,
                         const DepthBufferOptions& options)
    : samples_(samples),
      options_(options),
      columns_((model.intrinsics().width + options.cell_px - 1) / options.cell_px),
      rows_((model.intrinsics().height + options.cell_px - 1) / options.cell_px),
      entries_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
  const double focal_px = 0.5 * (model.intrinsics().fx + model.intrinsics().fy);
  const Eigen::Matrix3f R = T_C_G.R.cast<float>();
  const Eigen::Vector3f t = T_C_G.t.cast<float>();
  const auto least_cos = static_cast<float>(model.widest_cos());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    // Most of a map lies beside or behind: told quickly.
    const Eigen::Vector3f near = R * samples[k].p_G + t;
    if (near.z() < least_cos * near.norm()) continue;
    const Vector3d p_C = near.cast<double>();
    const auto pixel = model.project(p_C);
    if (!pixel) continue;
    const double range_m = p_C.norm();
    // Half of a sample's width as the camera sees it, without the half cell that it covers anyway.
    const double half_px = 0.5 * focal_px * options.sample_m / std::max(range_m, 1e-3) - 0.5 * options.cell_px;
    const int reach = std::clamp(static_cast<int>(std::ceil(half_px / options.cell_px)), 0, max_splat_cells);
    const double margin = (reach + 1.0) * options.cell_px;
    if (pixel->x() < -margin || pixel->y() < -margin || pixel->x() > model.intrinsics().width + margin ||
        pixel->y() > model.intrinsics().height + margin) {
      continue;
    }
    const int c = column(pixel->x());
    const int r = row(pixel->y());
    for (int y = std::max(0, r - reach); y <= std::min(rows_ - 1, r + reach); ++y) {
      for (int x = std::max(0, c - reach); x <= std::min(columns_ - 1, c + reach); ++x) {
        Entry& e =
            entries_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)];
        if (e.range_m != 0.0F && e.range_m <= static_cast<float>(range_m)) continue;
        e = {static_cast<float>(range_m), static_cast<std::uint32_t>(k)};
      }
    }
  }
}

int DepthBuffer::column(double x) const { return static_cast<int>(std::floor((x + 0.5) / options_.cell_px)); }
int DepthBuffer::row(double y) const { return static_cast<int>(std::floor((y + 0.5) / options_.cell_px)); }

template <class Accept>
bool DepthBuffer::unhidden(const Eigen::Vector2d& pixel, double range_m, const Accept& hides) const {
  const double limit_m = range_m - options_.tolerance_m - options_.tolerance_per_m * range_m;
  const int c = column(pixel.x());
  const int r = row(pixel.y());
  for (int y = std::max(0, r - 1); y <= std::min(rows_ - 1, r + 1); ++y) {
    for (int x = std::max(0, c - 1); x <= std::min(columns_ - 1, c + 1); ++x) {
      const Entry& e = entry(x, y);
      if (e.range_m != 0.0F && e.range_m < limit_m && hides(samples_[e.sample])) return false;
    }
  }
  return true;
}

bool DepthBuffer::sees(const Eigen::Vector2d& pixel, double range_m) const {
  return unhidden(pixel, range_m, [](const MapSample&) { return true; });
}

bool DepthBuffer::sees(const Eigen::Vector2d& pixel, double range_m, const LidarEdge& edge) const {
  return unhidden(pixel, range_m, [&](const MapSample& sample) {
    const Vector3d d = sample.p_G.cast<double>() - edge.p_G;
    return std::abs(d.dot(edge.normal_a_G)) > options_.own_plane_m &&
           std::abs(d.dot(edge.normal_b_G)) > options_.own_plane_m;
  });
}

bool DepthBuffer::on_plane_of(const MapSample& own, const MapSample& other) const {
  return own.normal_G.squaredNorm() > 0.0F &&
         std::abs(own.normal_G.dot(other.p_G - own.p_G)) <= static_cast<float>(options_.own_plane_m);
}

bool DepthBuffer::sees(const Eigen::Vector2d& pixel, double range_m, const MapSample& own) const {
  return unhidden(pixel, range_m, [&](const MapSample& sample) { return !on_plane_of(own, sample); });
}

bool DepthBuffer::near_silhouette(const Eigen::Vector2d& pixel, double range_m, const MapSample& own, int cells) const {
  const double step_m = options_.tolerance_m + options_.tolerance_per_m * range_m;
  const int c = column(pixel.x());
  const int r = row(pixel.y());
  for (int y = std::max(0, r - cells); y <= std::min(rows_ - 1, r + cells); ++y) {
    for (int x = std::max(0, c - cells); x <= std::min(columns_ - 1, c + cells); ++x) {
      const Entry& e = entry(x, y);
      if (e.range_m == 0.0F) return true;
      if (std::abs(e.range_m - range_m) > step_m && !on_plane_of(own, samples_[e.sample])) return true;
    }
  }
  return false;
}

double DepthBuffer::range_at(const Eigen::Vector2d& pixel) const {
  const int c = column(pixel.x());
  const int r = row(pixel.y());
  return c < 0 || r < 0 || c >= columns_ || r >= rows_ ? 0.0 : static_cast<double>(entry(c, r).range_m);
}

double DepthBuffer::filled_share() const {
  const auto filled = std::count_if(entries_.begin(), entries_.end(), [](const Entry& e) { return e.range_m > 0.0F; });
  return entries_.empty() ? 0.0 : static_cast<double>(filled) / static_cast<double>(entries_.size());
}

}  // namespace rigcal
