#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/camera/camera_scene.h"
#include "core/rig/camera_model.h"

namespace rigcal {

struct DepthBufferOptions {
  double sample_m = 0.05;         ///< Width of a sample of the map.
  std::size_t stride = 1;         ///< Every so many samples one takes part, so much wider: quicker, and coarser.
  double tolerance_m = 0.12;      ///< What lies so far behind the nearest surface is still seen,
  double tolerance_per_m = 0.01;  ///< and so much more for each metre of its range.
};

/// The nearest surface of the map in each small square of an image: tells what a camera sees and what something else
/// hides from it.
class DepthBuffer {
 public:
  /// `T_C_G` maps the world into the camera's optical frame. `samples` must outlive the buffer; `blocks` are theirs, as
  /// CameraScene has them.
  DepthBuffer(const CameraModel& model, const SE3& T_C_G, std::span<const MapSample> samples,
              std::span<const SampleBlock> blocks = {}, const DepthBufferOptions& options = {});

  /// Whether a sample of the map at `pixel`, `range_m` from the camera, is seen: nothing in the 3 x 3 cells around it
  /// is nearer by more than the tolerance, but for its own plane, however flat the camera looks along it.
  [[nodiscard]] bool sees(const Eigen::Vector2d& pixel, double range_m, const MapSample& own) const;
  /// The same for a point of an edge: what lies on (or near) either of its faces does not hide it.
  [[nodiscard]] bool sees(const Eigen::Vector2d& pixel, double range_m, const LidarEdge& edge) const;
  /// Whether a cell within `cells` of the pixel's is empty, or its range steps by more than the tolerance from
  /// `range_m` and not along the sample's own plane: a silhouette is near.
  [[nodiscard]] bool near_silhouette(const Eigen::Vector2d& pixel, double range_m, const MapSample& own,
                                     int cells) const;

 private:
  /// Range and index of a sample in one number, so that the nearer is the smaller.
  using Entry = std::uint64_t;
  class Filling;

  static Entry entry_of(float range_m, std::size_t sample);
  static float range_of(Entry entry);  ///< Not a number where there is nothing.
  static std::uint32_t sample_of(Entry entry) { return static_cast<std::uint32_t>(entry); }

  [[nodiscard]] int column(double x) const;
  [[nodiscard]] int row(double y) const;
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }
  void find_nearest_around();
  [[nodiscard]] bool on_plane_of(const MapSample& own, const MapSample& other) const;
  template <class Accept>
  [[nodiscard]] bool unhidden(const Eigen::Vector2d& pixel, double range_m, const Accept& hides) const;

  std::span<const MapSample> samples_;
  DepthBufferOptions options_;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<Entry> entries_;
  std::vector<float> nearest_around_;  ///< In the 3 x 3 cells around each; infinite where there is nothing.
};

}  // namespace rigcal
