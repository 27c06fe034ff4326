#include "core/pipeline/map_colours.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/base/parallel.h"
#include "core/camera/depth_buffer.h"
#include "core/camera/sample_blocks.h"
#include "core/edges/grey_image.h"
#include "core/records/pixel_format.h"
#include "core/voxel/cube_key.h"
#include "core/voxel/key_numbers.h"

namespace rigcal {
namespace {

constexpr std::size_t nearest_views = 3;  // of each camera
// Of the brightest channel: between these a colour is as the camera saw it; outside of the outer ones it says nothing.
constexpr float black = 4.0F;
constexpr float dark = 32.0F;
constexpr float bright = 230.0F;
constexpr float saturated = 250.0F;
constexpr float weight_of_bad = 0.02F;

// For each sample the views of each camera that see it from nearest by.
class SeenFrom {
 public:
  struct Slot {
    std::uint16_t range_cm = none;
    std::uint16_t view = 0;
  };
  static constexpr std::uint16_t none = 0xFFFF;

  SeenFrom(std::size_t samples, std::size_t cameras)
      : of_sample_(cameras * nearest_views), slots_(samples * of_sample_) {}

  /// Whether a view from so far would be one of those.
  [[nodiscard]] bool takes(std::size_t sample, std::size_t camera, float range_m) const {
    return cm_of(range_m) < slots_[sample * of_sample_ + (camera + 1) * nearest_views - 1].range_cm;
  }
  void add(std::size_t sample, std::size_t camera, float range_m, std::uint16_t view) {
    Slot slot{cm_of(range_m), view};
    Slot* const slots = &slots_[sample * of_sample_ + camera * nearest_views];
    for (std::size_t k = 0; k < nearest_views; ++k) {
      if (slot.range_cm < slots[k].range_cm) std::swap(slot, slots[k]);
    }
  }
  [[nodiscard]] std::span<const Slot> of(std::size_t sample) const {
    return std::span(slots_).subspan(sample * of_sample_, of_sample_);
  }

 private:
  static std::uint16_t cm_of(float range_m) {
    return static_cast<std::uint16_t>(std::min(100.0F * range_m, none - 1.0F));
  }

  std::size_t of_sample_;
  std::vector<Slot> slots_;
};

// A view with what tells quickly that it does not see something.
struct Eye {
  Eye(const ColourView& from, std::span<const MapSample> samples, std::span<const SampleBlock> blocks)
      : view(&from),
        R(from.T_C_G.R.cast<float>()),
        t(from.T_C_G.t.cast<float>()),
        cone(from.T_C_G, from.model),
        depth(from.model, from.T_C_G, samples, blocks) {}

  const ColourView* view;
  Eigen::Matrix3f R;
  Eigen::Vector3f t;
  ViewCone cone;
  DepthBuffer depth;
};

// The eyes that may see a block, those nearest to it first: what they see need not be asked of the others.
std::vector<std::uint16_t> eyes_of(const SampleBlock& block, const std::vector<std::unique_ptr<Eye>>& eyes) {
  std::vector<std::pair<float, std::uint16_t>> near;
  for (std::size_t v = 0; v < eyes.size(); ++v) {
    if (!eyes[v]->cone.meets(block)) continue;
    near.emplace_back(eyes[v]->cone.distance(block), static_cast<std::uint16_t>(v));
  }
  std::sort(near.begin(), near.end());
  std::vector<std::uint16_t> out;
  for (const auto& [distance, v] : near) out.push_back(v);
  return out;
}

SeenFrom who_sees(std::span<const ColourView> views, std::span<const MapSample> samples,
                  std::span<const SampleBlock> blocks) {
  std::vector<std::unique_ptr<Eye>> eyes(views.size());
  parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) eyes[v] = std::make_unique<Eye>(views[v], samples, blocks);
  });
  std::size_t cameras = 0;
  for (const ColourView& view : views) cameras = std::max(cameras, view.camera + 1);
  SeenFrom seen(samples.size(), cameras);
  parallel_for(blocks.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      for (const std::uint16_t v : eyes_of(blocks[b], eyes)) {
        const Eye& eye = *eyes[v];
        for (std::uint32_t i = blocks[b].begin; i < blocks[b].end; ++i) {
          const Eigen::Vector3f p = eye.R * samples[i].p_G + eye.t;
          const float range = p.norm();
          if (!seen.takes(i, eye.view->camera, range) || !eye.cone.holds(samples[i].p_G)) continue;
          const auto pixel = eye.view->model.project(p.cast<double>());
          if (!pixel || !eye.view->model.contains(*pixel) || !eye.depth.sees(*pixel, range, samples[i])) continue;
          seen.add(i, eye.view->camera, range, v);
        }
      }
    }
  });
  return seen;
}

using Rgb = Eigen::Vector3f;

Rgb colour_at(const ColourPicture& picture, const Eigen::Vector2d& pixel) {
  const auto place = [&](double at, int size) {
    return std::clamp(static_cast<int>((at + 0.5) / picture.shrink), 0, size - 1);
  };
  const int x = place(pixel.x(), picture.rgb.width);
  const int y = place(pixel.y(), picture.rgb.height);
  return Eigen::Vector3i(picture.rgb.at(x, y, 0), picture.rgb.at(x, y, 1), picture.rgb.at(x, y, 2)).cast<float>();
}

// How far a colour can be believed: 1 where it is well exposed, next to nothing where it is black or saturated.
float exposure_weight(const Rgb& colour) {
  const float most = colour.maxCoeff();
  const float weight = std::min((most - black) / (dark - black), (saturated - most) / (saturated - bright));
  return std::clamp(weight, weight_of_bad, 1.0F);
}

std::array<std::uint8_t, 3> colour_of(const MapPoint& point, std::span<const SeenFrom::Slot> seen,
                                      std::span<const ColourView> views) {
  Rgb sum = Rgb::Zero();
  float weights = 0.0F;
  for (const SeenFrom::Slot& slot : seen) {
    if (slot.range_cm == SeenFrom::none) continue;
    const ColourView& view = views[slot.view];
    const auto pixel = view.model.project(view.T_C_G * Vector3d(point.x, point.y, point.z));
    if (!pixel || !view.model.contains(*pixel)) continue;
    const Rgb colour = colour_at(view.picture, *pixel);
    const float weight = exposure_weight(colour) / std::max(0.1F, 0.01F * static_cast<float>(slot.range_cm));
    sum += weight * colour;
    weights += weight;
  }
  if (weights == 0.0F) return {point.reflectivity, point.reflectivity, point.reflectivity};
  const Rgb mean = sum / weights + Rgb::Constant(0.5F);
  return {static_cast<std::uint8_t>(mean.x()), static_cast<std::uint8_t>(mean.y()),
          static_cast<std::uint8_t>(mean.z())};
}

// Of a block of cubes, each way: so many fit into a cache.
constexpr int block_cubes = sample_block_cubes;

// The cube of a block that holds p, for `per_m` cubes a metre.
std::size_t cube_in_block(const Eigen::Vector3f& p, double per_m) {
  const auto part = [&](float x) {
    const double cube = std::floor(x * per_m);
    return static_cast<std::size_t>(cube - block_cubes * std::floor(cube / block_cubes));
  };
  return (part(p.x()) * block_cubes + part(p.y())) * block_cubes + part(p.z());
}

// What lies in each block, by its index, in order.
struct Members {
  std::vector<std::uint32_t> starts;
  std::vector<std::uint32_t> of_block;

  Members(const std::vector<std::uint32_t>& block_of, std::size_t blocks) : starts(blocks + 1, 0) {
    for (const std::uint32_t block : block_of) {
      if (block != KeyNumbers::unknown) ++starts[block + 1];
    }
    for (std::size_t b = 1; b < starts.size(); ++b) starts[b] += starts[b - 1];
    of_block.resize(starts.back());
    std::vector<std::uint32_t> next(starts.begin(), starts.end() - 1);
    for (std::size_t i = 0; i < block_of.size(); ++i) {
      if (block_of[i] != KeyNumbers::unknown) of_block[next[block_of[i]]++] = static_cast<std::uint32_t>(i);
    }
  }
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t block) const {
    return std::span(of_block).subspan(starts[block], starts[block + 1] - starts[block]);
  }
};

Eigen::Vector3f place_of(const MapPoint& point) { return {point.x, point.y, point.z}; }

}  // namespace

ColourPicture colour_picture(const Image& image, int bits) {
  constexpr int max_pixels = 1 << 20;
  const auto format = parse_pixel_format(image.pixel_format);
  const bool mosaic = is_mosaic(image);
  ColourPicture out;
  out.shrink = mosaic ? 2 : 1;
  while ((image.width / out.shrink) * (image.height / out.shrink) > max_pixels) out.shrink += mosaic ? 2 : 1;
  out.rgb.width = std::max(1, image.width / out.shrink);
  out.rgb.height = std::max(1, image.height / out.shrink);
  out.rgb.channels = 3;
  out.rgb.bytes.resize(out.rgb.row_bytes() * static_cast<std::size_t>(out.rgb.height));
  const float scale = 255.0F / static_cast<float>((1 << bits) - 1);
  std::size_t to = 0;
  for (int v = 0; v < out.rgb.height; ++v) {
    for (int u = 0; u < out.rgb.width; ++u) {
      std::array<float, 3> sums{};
      std::array<float, 3> counts{};
      for (int y = v * out.shrink; y < std::min(image.height, (v + 1) * out.shrink); ++y) {
        for (int x = u * out.shrink; x < std::min(image.width, (u + 1) * out.shrink); ++x) {
          for (int c = 0; c < 3; ++c) {
            if (mosaic && bayer_colour(format->layout, x, y) != c) continue;
            sums[static_cast<std::size_t>(c)] += static_cast<float>(image.at(x, y, image.channels == 3 ? c : 0));
            counts[static_cast<std::size_t>(c)] += 1.0F;
          }
        }
      }
      for (std::size_t c = 0; c < 3; ++c) {
        const float value = counts[c] > 0.0F ? scale * sums[c] / counts[c] : 0.0F;
        out.rgb.bytes[to++] = static_cast<std::uint8_t>(std::min(255.0F, value + 0.5F));
      }
    }
  }
  return out;
}

std::vector<std::array<std::uint8_t, 3>> colour_map(std::span<const MapPoint> map, std::span<const ColourView> views,
                                                    std::span<const MapSample> samples,
                                                    std::span<const SampleBlock> blocks, double sample_m) {
  std::vector<std::array<std::uint8_t, 3>> out(map.size());
  const SeenFrom seen = who_sees(views, samples, blocks);
  // Block by block: who asks for what lies together finds it in the caches.
  const double per_m = 1.0 / sample_m;
  KeyNumbers numbers;
  std::vector<std::uint32_t> block_of(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i)
    block_of[i] = numbers.meet(cube_key(samples[i].p_G, per_m / block_cubes)).number;
  const Members samples_of(block_of, numbers.size());
  block_of.resize(map.size());
  parallel_for(map.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      block_of[i] = numbers.find(cube_key(place_of(map[i]), per_m / block_cubes));
      if (block_of[i] == KeyNumbers::unknown) out[i] = colour_of(map[i], {}, views);
    }
  });
  const Members points_of(block_of, numbers.size());
  parallel_for(numbers.size(), 16, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> sample_of(block_cubes * block_cubes * block_cubes, KeyNumbers::unknown);
    for (std::size_t b = begin; b < end; ++b) {
      for (const std::uint32_t i : samples_of.of(b)) {
        std::uint32_t& sample = sample_of[cube_in_block(samples[i].p_G, per_m)];
        sample = std::min(sample, i);  // of each cube the first
      }
      for (const std::uint32_t i : points_of.of(b)) {
        const std::uint32_t sample = sample_of[cube_in_block(place_of(map[i]), per_m)];
        out[i] = colour_of(map[i], sample == KeyNumbers::unknown ? std::span<const SeenFrom::Slot>() : seen.of(sample),
                           views);
      }
      for (const std::uint32_t i : samples_of.of(b))
        sample_of[cube_in_block(samples[i].p_G, per_m)] = KeyNumbers::unknown;
    }
  });
  return out;
}

}  // namespace rigcal
