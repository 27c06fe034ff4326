#include "core/camera/depth_buffer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "core/camera/sample_blocks.h"

namespace rigcal {
namespace {

constexpr int cell_px = 4;            // Edge of a cell of the buffer.
constexpr double own_plane_m = 0.08;  // What lies so near to a point's own faces does not hide it.

// A surface that fills the view would be splatted over everything; beyond this it is near enough to be dense anyway.
constexpr int max_splat_cells = 12;

constexpr std::uint64_t nothing = ~std::uint64_t{0};

}  // namespace

DepthBuffer::Entry DepthBuffer::entry_of(float range_m, std::size_t sample) {
  // Floats that are not negative are in the order of their bits.
  return std::uint64_t{std::bit_cast<std::uint32_t>(range_m)} << 32 | static_cast<std::uint32_t>(sample);
}

float DepthBuffer::range_of(Entry entry) { return std::bit_cast<float>(static_cast<std::uint32_t>(entry >> 32)); }

// A sample covers a square of cells that grows with its nearness. Not every sample is written to all cells of its own:
// those of the widest squares go into a grid, which then is widened by a cell all around, and so on down to those that
// cover one cell.
class DepthBuffer::Filling {
 public:
  Filling(const CameraModel& model, const DepthBufferOptions& options, int columns, int rows)
      : model_(model),
        columns_(columns + 2 * max_splat_cells),
        rows_(rows + 2 * max_splat_cells),
        cells_per_px_(1.0 / cell_px),
        half_cells_m_(0.5 * 0.5 * (model.intrinsics().fx + model.intrinsics().fy) * options.sample_m *
                      std::sqrt(static_cast<double>(options.stride)) / cell_px) {}

  void add(const Vector3d& p_C, float range_m, std::size_t sample) {
    const auto pixel = model_.project(p_C);
    if (!pixel) return;
    // Half of a sample's width as the camera sees it, without the half cell that it covers anyway.
    const double half = std::min<double>(max_splat_cells, half_cells_m_ / std::max(range_m, 1e-3F) - 0.5);
    const int whole = static_cast<int>(std::max(0.0, half));
    const int reach = half > whole ? whole + 1 : whole;
    // In cells of the grid, which begins that far outside of the image.
    const double x = (pixel->x() + 0.5) * cells_per_px_ + max_splat_cells;
    const double y = (pixel->y() + 0.5) * cells_per_px_ + max_splat_cells;
    if (!(x >= max_splat_cells - reach) || !(y >= max_splat_cells - reach) ||
        !(x < columns_ - max_splat_cells + reach) || !(y < rows_ - max_splat_cells + reach)) {
      return;
    }
    of_reach_[static_cast<std::size_t>(reach)].push_back(
        {static_cast<std::uint32_t>(static_cast<int>(y) * columns_ + static_cast<int>(x)), entry_of(range_m, sample)});
  }

  // The cells of the image alone.
  [[nodiscard]] std::vector<Entry> take() {
    grid_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), nothing);
    std::size_t reach = of_reach_.size() - 1;
    while (reach > 0 && of_reach_[reach].empty()) --reach;
    for (; reach > 0; --reach) {
      write(reach);
      widen();
    }
    write(0);
    std::vector<Entry> inside;
    for (int r = max_splat_cells; r < rows_ - max_splat_cells; ++r) {
      const auto row = grid_.begin() + static_cast<std::ptrdiff_t>(r) * columns_;
      inside.insert(inside.end(), row + max_splat_cells, row + columns_ - max_splat_cells);
    }
    return inside;
  }

 private:
  struct Splat {
    std::uint32_t cell;
    Entry entry;
  };

  void write(std::size_t reach) {
    for (const Splat& splat : of_reach_[reach]) grid_[splat.cell] = std::min(grid_[splat.cell], splat.entry);
  }

  // Each cell gets the least of the 3 x 3 around it. The grid's own border has nothing to give but to the image.
  void widen() {
    const auto width = static_cast<std::size_t>(columns_);
    across_.resize(grid_.size());
    for (std::size_t i = 1; i + 1 < grid_.size(); ++i)
      across_[i] = std::min(grid_[i], std::min(grid_[i - 1], grid_[i + 1]));
    across_.front() = grid_.front();
    across_.back() = grid_.back();
    for (std::size_t i = width; i + width < grid_.size(); ++i)
      grid_[i] = std::min(across_[i], std::min(across_[i - width], across_[i + width]));
  }

  const CameraModel& model_;
  int columns_;
  int rows_;
  double cells_per_px_;
  double half_cells_m_;
  std::array<std::vector<Splat>, max_splat_cells + 1> of_reach_;
  std::vector<Entry> grid_;
  std::vector<Entry> across_;
};

DepthBuffer::DepthBuffer(const CameraModel& model, const SE3& T_C_G, std::span<const MapSample> samples,
                         std::span<const SampleBlock> blocks, const DepthBufferOptions& options)
    : samples_(samples),
      options_(options),
      columns_((model.intrinsics().width + cell_px - 1) / cell_px),
      rows_((model.intrinsics().height + cell_px - 1) / cell_px) {
  const Eigen::Matrix3f R = T_C_G.R.cast<float>();
  const Eigen::Vector3f t = T_C_G.t.cast<float>();
  const ViewCone cone(T_C_G, model);
  Filling filling(model, options, columns_, rows_);
  for_each_run(samples.size(), blocks, cone, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = first_from(begin, options.stride); k < end; k += options.stride) {
      if (!cone.holds(samples[k].p_G)) continue;
      const Eigen::Vector3f p_C = R * samples[k].p_G + t;
      filling.add(p_C.cast<double>(), p_C.norm(), k);
    }
  });
  entries_ = filling.take();
  find_nearest_around();
}

void DepthBuffer::find_nearest_around() {
  constexpr float far = std::numeric_limits<float>::infinity();
  nearest_around_.assign(entries_.size(), far);
  std::vector<float> across(entries_.size());
  for (int r = 0; r < rows_; ++r) {
    float before = far;
    for (int c = 0; c < columns_; ++c) {
      const auto range = [&](int at) {
        return at < columns_ && entries_[index(at, r)] != nothing ? range_of(entries_[index(at, r)]) : far;
      };
      const float here = range(c);
      across[index(c, r)] = std::min(before, std::min(here, range(c + 1)));
      before = here;
    }
  }
  for (int r = 0; r < rows_; ++r) {
    for (int c = 0; c < columns_; ++c) {
      float nearest = across[index(c, r)];
      if (r > 0) nearest = std::min(nearest, across[index(c, r - 1)]);
      if (r + 1 < rows_) nearest = std::min(nearest, across[index(c, r + 1)]);
      nearest_around_[index(c, r)] = nearest;
    }
  }
}

int DepthBuffer::column(double x) const { return static_cast<int>(std::floor((x + 0.5) / cell_px)); }
int DepthBuffer::row(double y) const { return static_cast<int>(std::floor((y + 0.5) / cell_px)); }

template <class Accept>
bool DepthBuffer::unhidden(const Eigen::Vector2d& pixel, double range_m, const Accept& hides) const {
  const double limit_m = range_m - options_.tolerance_m - options_.tolerance_per_m * range_m;
  const int c = column(pixel.x());
  const int r = row(pixel.y());
  const bool inside = c >= 0 && r >= 0 && c < columns_ && r < rows_;
  if (inside && nearest_around_[index(c, r)] >= limit_m) return true;
  for (int y = std::max(0, r - 1); y <= std::min(rows_ - 1, r + 1); ++y) {
    for (int x = std::max(0, c - 1); x <= std::min(columns_ - 1, c + 1); ++x) {
      const Entry entry = entries_[index(x, y)];
      if (range_of(entry) < limit_m && hides(samples_[sample_of(entry)])) return false;
    }
  }
  return true;
}

bool DepthBuffer::sees(const Eigen::Vector2d& pixel, double range_m, const LidarEdge& edge) const {
  return unhidden(pixel, range_m, [&](const MapSample& sample) {
    const Vector3d d = sample.p_G.cast<double>() - edge.p_G;
    return std::abs(d.dot(edge.normal_a_G)) > own_plane_m && std::abs(d.dot(edge.normal_b_G)) > own_plane_m;
  });
}

bool DepthBuffer::on_plane_of(const MapSample& own, const MapSample& other) const {
  return own.normal_G.squaredNorm() > 0.0F &&
         std::abs(own.normal_G.dot(other.p_G - own.p_G)) <= static_cast<float>(own_plane_m);
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
      const Entry entry = entries_[index(x, y)];
      if (entry == nothing) return true;
      if (std::abs(range_of(entry) - range_m) > step_m && !on_plane_of(own, samples_[sample_of(entry)])) return true;
    }
  }
  return false;
}

}  // namespace rigcal
