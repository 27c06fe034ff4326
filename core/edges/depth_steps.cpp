#include "core/edges/depth_steps.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/wide.h"

namespace rigcal {
namespace {

constexpr double min_step_m = 0.15;       // The far surface is so much farther,
constexpr double min_step_per_m = 0.005;  // or so much for each metre of range,
constexpr double min_slope = 4.0;         // and what lies between is so steep in space,
constexpr double min_slope_alone = 15.0;  // where nothing tells how the near surface goes on: it may be seen flat.
constexpr double range_noise_m = 0.02;
constexpr double reach_spacings = 1.5;       // Rays so near to each other are neighbours.
constexpr double same_surface_m = 0.1;       // Neighbours of the near ray on its own surface differ by less,
constexpr double same_surface_per_m = 0.01;  // and so much more for each metre:
constexpr int min_support = 3;               // so many must be there, or it is a stray point.

struct Ray {
  float u;
  float v;
  float inverse_depth;
  float range_m;
};

// Rays that are looked at together.
constexpr std::int32_t at_a_time = 16;

// Rays of some rows of cells, each of which is one stretch of these arrays: u, v and range, to be read up to a whole
// number of looks. A row goes from where one of `begins` says to where one of `ends` says.
struct Rows {
  std::array<const float*, 3> rays;
  const std::uint32_t* begins;
  const std::uint32_t* ends;
  std::size_t apart;  // in `begins` and `ends`
  std::size_t count;
};

// From a ray to one that is farther.
struct Steepness {
  float u;
  float v;
  float range_m;
  float reach2;
  float slope2;  // in metres for each unit of u and v
};

// Some rays of a row, looked at together; those from `left` on are none of it.
struct Look {
  const float* u;
  const float* v;
  const float* range_m;
  std::int32_t first;  // the place of the first of them
  std::int32_t left;
};

// Calls `visit(look)` until it says that this is enough; true then. Part of the functions for wide vectors that call
// it.
template <class Visit>
[[gnu::always_inline]] inline bool look_through(const Rows& rows, const Visit& visit) {
  for (std::size_t row = 0; row < rows.count; ++row) {
    const std::uint32_t end = rows.ends[row * rows.apart];
    for (std::uint32_t at = rows.begins[row * rows.apart]; at < end; at += at_a_time) {
      if (visit(Look{rows.rays[0] + at, rows.rays[1] + at, rows.rays[2] + at, static_cast<std::int32_t>(at),
                     static_cast<std::int32_t>(end - at)})) {
        return true;
      }
    }
  }
  return false;
}

// Yes and no are reckoned with as numbers below: with branches a loop is not done with all of a look at once.
constexpr std::int32_t number_of(bool yes) { return static_cast<std::int32_t>(yes); }

// Whether any of the rays is within reach and so steep, but for rounding.
RIGCAL_WIDE bool any_steep(const Rows& rows, const Steepness& wanted) {
  return look_through(rows, [&](const Look& look) {
    std::int32_t any = 0;
    for (std::int32_t i = 0; i < at_a_time; ++i) {
      const float du = look.u[i] - wanted.u;
      const float dv = look.v[i] - wanted.v;
      const float d2 = du * du + dv * dv;
      const float rise = look.range_m[i] - wanted.range_m;
      any |= number_of(i < look.left) & number_of(d2 < wanted.reach2) & number_of(rise > 0.0F) &
             number_of(rise * rise > 0.999F * wanted.slope2 * d2);
    }
    return any != 0;
  });
}

constexpr std::size_t sides = 4;  // right, left, up, down: one and its opposite differ in the last bit

// Around a ray.
struct Vicinity {
  float u;
  float v;
  float range_m;
  float reach2;
  float same_m;  // Rays on its surface differ in range by less.
};

struct Neighbours {
  std::array<float, sides> distance2;       // of the nearest ray to each side; reach2 where there is none
  std::array<std::int32_t, sides> nearest;  // the first of those as near
  std::int32_t support = 0;                 // how many lie on the same surface
};

// Of the rays of a look.
using Floats = std::array<float, at_a_time>;
using Ints = std::array<std::int32_t, at_a_time>;

// Lane by lane first: each has its own nearest rays, of which the nearest are told at the end.
RIGCAL_WIDE void find_neighbours(const Rows& rows, const Vicinity& around, Neighbours& out) {
  std::array<Floats, sides> least;
  for (Floats& each : least) each.fill(around.reach2);
  std::array<Ints, sides> nearest{};
  Ints support{};
  look_through(rows, [&](const Look& look) {
    Floats distance2;
    Ints on_side;
    for (std::int32_t i = 0; i < at_a_time; ++i) {
      const auto lane = static_cast<std::size_t>(i);
      const float du = look.u[i] - around.u;
      const float dv = look.v[i] - around.v;
      const float d2 = du * du + dv * dv;
      const float rise = std::abs(look.range_m[i] - around.range_m);
      const std::int32_t side_u = number_of(du <= 0.0F);
      const std::int32_t side_v = 2 + number_of(dv <= 0.0F);
      const std::int32_t side = side_v + number_of(std::abs(du) > std::abs(dv)) * (side_u - side_v);
      // The ray itself is no neighbour.
      const std::int32_t near = number_of(i < look.left) & number_of(d2 > 0.0F) & number_of(d2 < around.reach2);
      support[lane] += near & number_of(rise < around.same_m);
      on_side[lane] = side | (1 - near) * 4;
      distance2[lane] = d2;
    }
    for (std::size_t side = 0; side < sides; ++side) {
      Floats& best = least[side];
      Ints& which = nearest[side];
      for (std::size_t i = 0; i < at_a_time; ++i) {
        const bool nearer = static_cast<bool>(number_of(on_side[i] == static_cast<std::int32_t>(side)) &
                                              number_of(distance2[i] < best[i]));
        best[i] = nearer ? distance2[i] : best[i];
        which[i] = nearer ? look.first + static_cast<std::int32_t>(i) : which[i];
      }
    }
    return false;
  });
  out.support = 0;
  for (std::size_t i = 0; i < at_a_time; ++i) out.support += support[i];
  for (std::size_t side = 0; side < sides; ++side) {
    Ints bits;
    std::memcpy(bits.data(), least[side].data(), sizeof bits);
    // Numbers that are not negative are in the order of their bits.
    std::int32_t best = std::numeric_limits<std::int32_t>::max();
    for (std::size_t i = 0; i < at_a_time; ++i) best = std::min(best, bits[i]);
    std::int32_t which = std::numeric_limits<std::int32_t>::max();
    for (std::size_t i = 0; i < at_a_time; ++i) which = std::min(which, bits[i] == best ? nearest[side][i] : which);
    std::memcpy(&out.distance2[side], &best, sizeof best);
    out.nearest[side] = which;
  }
}

// Rays of one face, sorted by the square cells that hold them.
class FaceGrid {
 public:
  explicit FaceGrid(const std::vector<Ray>& rays) {
    set_spacings(rays);
    columns_ = std::clamp(static_cast<int>(1.0 / mean_spacing_), 8, 1000);
    starts_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(columns_) + 1, 0);
    for (const Ray& ray : rays) ++starts_[cell(ray.u, ray.v) + 1];
    for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    rays_.resize(rays.size());
    std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
    for (const Ray& ray : rays) rays_[next[cell(ray.u, ray.v)]++] = ray;
    for (std::vector<float>& column : columns_of_rays_) column.reserve(rays_.size() + at_a_time);
    for (const Ray& ray : rays_) {
      columns_of_rays_[0].push_back(ray.u);
      columns_of_rays_[1].push_back(ray.v);
      columns_of_rays_[2].push_back(ray.range_m);
    }
    for (std::vector<float>& column : columns_of_rays_) column.resize(rays_.size() + at_a_time, 0.0F);
    set_spans();
  }

  /// Whether all rays around a place, at least as far as the width of a span's cell, have ranges within `span_m` of
  /// each other: quick to tell, and true of most.
  [[nodiscard]] bool is_even(float u, float v, float span_m) const {
    const Span& span = spans_[span_cell(u, v)];
    return span.high - span.low < span_m;
  }

  [[nodiscard]] const std::vector<Ray>& rays() const { return rays_; }

  /// Mean distance of neighbours around a place.
  [[nodiscard]] float spacing(float u, float v) const { return spacings_[patch(u, v)]; }

  // Whether any ray within `reach` of one lies so much farther that what lies between may be as steep as `slope`.
  [[nodiscard]] bool may_end(const Ray& ray, float reach, float slope) const {
    return any_steep(rows_around(ray, reach),
                     {ray.u, ray.v, ray.range_m, reach * reach, slope * slope * ray.range_m * ray.range_m});
  }

  /// The rays nearer to one than `reach`: their numbers are places in `rays()`.
  void neighbours(const Ray& ray, float reach, float same_m, Neighbours& out) const {
    find_neighbours(rows_around(ray, reach), {ray.u, ray.v, ray.range_m, reach * reach, same_m}, out);
  }

 private:
  static constexpr int patches = 80;  // in each direction: 1.4 degrees in the middle of a face

  [[nodiscard]] static std::size_t patch(float u, float v) {
    const auto part = [](float x) {
      return static_cast<std::size_t>(std::clamp(static_cast<int>((x + 1.0F) * 0.5F * patches), 0, patches - 1));
    };
    return part(v) * patches + part(u);
  }

  // Density differs over a field of view; that of 3 x 3 patches together is steady enough.
  void set_spacings(const std::vector<Ray>& rays) {
    std::vector<int> counts(static_cast<std::size_t>(patches) * patches, 0);
    for (const Ray& ray : rays) ++counts[patch(ray.u, ray.v)];
    spacings_.assign(counts.size(), 0.0F);
    const float area = 4.0F / static_cast<float>(patches * patches);
    int occupied = 0;
    for (int y = 0; y < patches; ++y) {
      for (int x = 0; x < patches; ++x) {
        int sum = 0;
        int cells = 0;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            if (x + dx < 0 || y + dy < 0 || x + dx >= patches || y + dy >= patches) continue;
            const int count = counts[static_cast<std::size_t>((y + dy) * patches + x + dx)];
            sum += count;
            cells += count > 0 ? 1 : 0;
          }
        }
        const auto at = static_cast<std::size_t>(y * patches + x);
        if (counts[at] > 0) ++occupied;
        if (sum > 0) spacings_[at] = std::sqrt(area * static_cast<float>(cells) / static_cast<float>(sum));
      }
    }
    mean_spacing_ = std::sqrt(static_cast<double>(area) * occupied / static_cast<double>(rays.size()));
  }

  struct Span {
    float low = 1e9F;
    float high = 0.0F;
    void take(const Span& other) {
      low = std::min(low, other.low);
      high = std::max(high, other.high);
    }
  };
  static constexpr int span_columns = 400;

  [[nodiscard]] static std::size_t span_cell(float u, float v) {
    const auto part = [](float x) {
      return std::clamp(static_cast<int>((x + 1.0F) * 0.5F * span_columns), 0, span_columns - 1);
    };
    return static_cast<std::size_t>(part(v) * span_columns + part(u));
  }

  // Least and largest range of 3 x 3 cells.
  void set_spans() {
    std::vector<Span> own(static_cast<std::size_t>(span_columns) * span_columns);
    for (const Ray& ray : rays_) own[span_cell(ray.u, ray.v)].take({ray.range_m, ray.range_m});
    spans_ = own;
    for (int y = 0; y < span_columns; ++y) {
      for (int x = 0; x < span_columns; ++x) {
        const auto at = static_cast<std::size_t>(y * span_columns + x);
        if (own[at].high == 0.0F) continue;
        for (int j = std::max(0, y - 1); j <= std::min(span_columns - 1, y + 1); ++j) {
          for (int i = std::max(0, x - 1); i <= std::min(span_columns - 1, x + 1); ++i) {
            spans_[at].take(own[static_cast<std::size_t>(j * span_columns + i)]);
          }
        }
      }
    }
  }

  // Of the cells that hold all within `reach`.
  [[nodiscard]] Rows rows_around(const Ray& ray, float reach) const {
    const int y0 = column(ray.v - reach);
    const auto row = static_cast<std::size_t>(y0) * static_cast<std::size_t>(columns_);
    return {{columns_of_rays_[0].data(), columns_of_rays_[1].data(), columns_of_rays_[2].data()},
            &starts_[row + static_cast<std::size_t>(column(ray.u - reach))],
            &starts_[row + static_cast<std::size_t>(column(ray.u + reach)) + 1],
            static_cast<std::size_t>(columns_),
            static_cast<std::size_t>(column(ray.v + reach) - y0 + 1)};
  }

  [[nodiscard]] int column(float x) const {
    return std::clamp(static_cast<int>((x + 1.0F) * 0.5F * static_cast<float>(columns_)), 0, columns_ - 1);
  }
  [[nodiscard]] std::size_t cell(float u, float v) const {
    return static_cast<std::size_t>(column(v)) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column(u));
  }

  int columns_ = 0;
  double mean_spacing_ = 0.0;
  std::vector<float> spacings_;
  std::vector<Span> spans_;
  std::vector<std::uint32_t> starts_;
  std::vector<Ray> rays_;
  std::array<std::vector<float>, 3> columns_of_rays_;  ///< u, v and range, with room for one more look at the end.
};

class StepFinder {
 public:
  explicit StepFinder(const FaceGrid& grid) : grid_(grid) {}

  void look(const Ray& ray, std::vector<DepthStep>& steps) {
    const float spacing = grid_.spacing(ray.u, ray.v);
    const auto reach = static_cast<float>(reach_spacings) * spacing;
    if (grid_.is_even(ray.u, ray.v, static_cast<float>(min_step_m))) return;
    if (!grid_.may_end(ray, reach, static_cast<float>(min_slope))) return;
    const auto same = static_cast<float>(same_surface_m + same_surface_per_m * ray.range_m);
    Neighbours near;
    grid_.neighbours(ray, reach, same, near);
    if (near.support < min_support) return;
    const auto to = [&](std::size_t side) {
      const bool any = near.distance2[side] < reach * reach;
      return any ? &grid_.rays()[static_cast<std::size_t>(near.nearest[side])] : nullptr;
    };
    for (std::size_t side = 0; side < sides; ++side) {
      if (to(side) == nullptr) continue;
      const Ray& far = *to(side);
      const float apart = std::sqrt(near.distance2[side]);
      const float rise = rise_beyond(ray, far, apart, to(side ^ 1U), near.distance2[side ^ 1U]);
      if (rise < min_step_m || rise < min_step_per_m * ray.range_m) continue;
      steps.push_back({0.5F * (ray.u + far.u), 0.5F * (ray.v + far.v), ray.inverse_depth, (far.u - ray.u) / apart,
                       (far.v - ray.v) / apart, rise, spacing});
    }
  }

 private:
  // How much farther the far ray is than the near surface would be there, metres. A surface seen flat goes on as it
  // came: its inverse depth is linear. Where nothing tells how it came, a steep step is needed.
  [[nodiscard]] float rise_beyond(const Ray& ray, const Ray& far, float apart, const Ray* before, float before2) const {
    const float rise = far.range_m - ray.range_m;
    const auto slope = static_cast<double>(rise / (apart * ray.range_m));
    if (slope < min_slope) return 0.0F;
    if (slope > min_slope_alone) return rise;
    if (before == nullptr) return 0.0F;
    const float share = apart / std::sqrt(before2);
    const float expected = ray.inverse_depth + share * (ray.inverse_depth - before->inverse_depth);
    if (expected <= 0.0F) return 0.0F;
    const float noise_m = static_cast<float>(range_noise_m) * (1.0F + share);
    return far.range_m - ray.range_m * ray.inverse_depth / expected - 3.0F * noise_m;
  }

  const FaceGrid& grid_;
};

}  // namespace

FacePlace to_face(const Vector3d& p) {
  int axis = 0;
  p.cwiseAbs().maxCoeff(&axis);
  const bool back = p[axis] < 0.0;
  const double depth = std::abs(p[axis]);
  return {2 * axis + (back ? 1 : 0), p[(axis + 1) % 3] / depth, p[(axis + 2) % 3] / depth, 1.0 / depth};
}

Vector3d from_face(const FacePlace& place) {
  const int axis = place.face / 2;
  Vector3d p;
  p[axis] = place.face % 2 == 0 ? 1.0 : -1.0;
  p[(axis + 1) % 3] = place.u;
  p[(axis + 2) % 3] = place.v;
  return p / place.inverse_depth;
}

std::array<std::vector<DepthStep>, cube_faces> find_depth_steps(std::span<const Point> points) {
  std::array<std::vector<Ray>, cube_faces> rays;
  for (const Point& point : points) {
    const Vector3d p(point.x, point.y, point.z);
    const double range = p.norm();
    if (!(range > 0.0)) continue;
    const FacePlace at = to_face(p);
    rays[static_cast<std::size_t>(at.face)].push_back({static_cast<float>(at.u), static_cast<float>(at.v),
                                                       static_cast<float>(at.inverse_depth),
                                                       static_cast<float>(range)});
  }
  std::array<std::vector<DepthStep>, cube_faces> steps;
  for (std::size_t face = 0; face < rays.size(); ++face) {
    if (rays[face].empty()) continue;
    const FaceGrid grid(rays[face]);
    rays[face] = {};
    StepFinder finder(grid);
    for (const Ray& ray : grid.rays()) finder.look(ray, steps[face]);
  }
  return steps;
}

}  // namespace rigcal
