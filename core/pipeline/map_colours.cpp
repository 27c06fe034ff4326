#include "core/pipeline/map_colours.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/base/parallel.h"
#include "core/camera/depth_buffer.h"
#include "core/edges/grey_image.h"
#include "core/records/pixel_format.h"
#include "core/voxel/cube_index.h"

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

  void add(std::size_t sample, std::size_t camera, float range_m, std::uint16_t view) {
    Slot slot{static_cast<std::uint16_t>(std::min(100.0F * range_m, none - 1.0F)), view};
    Slot* const slots = &slots_[sample * of_sample_ + camera * nearest_views];
    for (std::size_t k = 0; k < nearest_views; ++k) {
      if (slot.range_cm < slots[k].range_cm) std::swap(slot, slots[k]);
    }
  }
  [[nodiscard]] std::span<const Slot> of(std::size_t sample) const {
    return std::span(slots_).subspan(sample * of_sample_, of_sample_);
  }

 private:
  std::size_t of_sample_;
  std::vector<Slot> slots_;
};

SeenFrom who_sees(std::span<const ColourView> views, std::span<const MapSample> samples) {
  std::vector<std::unique_ptr<DepthBuffer>> buffers(views.size());
  parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      buffers[v] = std::make_unique<DepthBuffer>(views[v].model, views[v].T_C_G, samples);
    }
  });
  std::vector<float> least_coses;
  for (const ColourView& view : views) least_coses.push_back(static_cast<float>(view.model.widest_cos()));
  std::size_t cameras = 0;
  for (const ColourView& view : views) cameras = std::max(cameras, view.camera + 1);
  SeenFrom seen(samples.size(), cameras);
  parallel_for(samples.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = 0; v < views.size(); ++v) {
      const CameraModel& model = views[v].model;
      const float least_cos = least_coses[v];
      const Eigen::Matrix3f R = views[v].T_C_G.R.cast<float>();
      const Eigen::Vector3f t = views[v].T_C_G.t.cast<float>();
      for (std::size_t i = begin; i < end; ++i) {
        const Eigen::Vector3f p = R * samples[i].p_G + t;
        const float range = p.norm();
        if (p.z() < least_cos * range) continue;  // most of a map lies beside or behind
        const auto pixel = model.project(p.cast<double>());
        if (!pixel || !model.contains(*pixel) || !buffers[v]->sees(*pixel, range)) continue;
        seen.add(i, views[v].camera, range, static_cast<std::uint16_t>(v));
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
                                                    std::span<const MapSample> samples, double sample_m) {
  std::vector<std::array<std::uint8_t, 3>> out(map.size());
  const SeenFrom seen = who_sees(views, samples);
  const double per_m = 1.0 / sample_m;
  KeyNumbers cubes;
  std::vector<std::uint32_t> sample_of;  // of each cube the first
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (cubes.meet(cube_key(samples[i].p_G, per_m)).first) sample_of.push_back(static_cast<std::uint32_t>(i));
  }
  parallel_for(map.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t cube = cubes.find(cube_key({map[i].x, map[i].y, map[i].z}, per_m));
      const auto from = cube == KeyNumbers::unknown ? std::span<const SeenFrom::Slot>() : seen.of(sample_of[cube]);
      out[i] = colour_of(map[i], from, views);
    }
  });
  return out;
}

}  // namespace rigcal
