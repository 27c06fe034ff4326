#include "core/camera/information_images.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/base/parallel.h"
#include "core/camera/joint_histogram.h"
#include "core/camera/sightings.h"

namespace rigcal {
namespace {

// Of so many pixels of an image each is counted.
constexpr std::size_t pixels_counted = 20'000;

std::array<double, 256> counts_of(const GreyImage& image) {
  std::array<double, 256> count{};
  const std::size_t stride = std::max<std::size_t>(1, image.values.size() / pixels_counted) | 1;
  for (std::size_t i = 0; i < image.values.size(); i += stride) {
    count[static_cast<std::size_t>(std::clamp(image.values[i], 0.0F, 255.0F))] += 1.0;
  }
  return count;
}

// From the darkest hundredth of an image to its brightest.
GreyScale spread_of(const GreyImage& image) {
  const std::array<double, 256> count = counts_of(image);
  const double total = std::accumulate(count.begin(), count.end(), 0.0);
  const auto value_at = [&](double share) {
    double below = 0.0;
    std::size_t v = 0;
    while (v + 1 < count.size() && below + count[v] < share * total) below += count[v++];
    return static_cast<float>(v);
  };
  const float dark = value_at(0.01);
  return {dark, std::max(dark + 1.0F, value_at(0.99)), static_cast<float>(grey_levels - 1)};
}

// Made smaller, and less the mean over some 80 pixels around; middle grey where they are alike.
GreyImage contrast_of(const GreyImage& image, int halvings) {
  constexpr int surroundings_halvings = 7;
  constexpr int step = 8;  // between which the mean is as good as straight
  GreyImage contrast = halved(image, halvings);
  const SmoothImage surroundings(contrast, std::max(0, surroundings_halvings - halvings));
  for (int y = 0; y < contrast.height; ++y) {
    float* row = contrast.values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(contrast.width);
    float right = surroundings.value(Eigen::Vector2d(0, y));
    for (int x0 = 0; x0 < contrast.width; x0 += step) {
      const float left = right;
      right = surroundings.value(Eigen::Vector2d(x0 + step, y));
      const float rise = (right - left) / step;
      for (int x = x0; x < std::min(x0 + step, contrast.width); ++x) {
        row[x] = std::clamp(128.0F + row[x] - left - rise * static_cast<float>(x - x0), 0.0F, 255.0F);
      }
    }
  }
  return contrast;
}

}  // namespace

std::vector<SmoothImage> information_images(const CameraScene& scene, const CameraTask& camera, int halvings,
                                            Shown shown) {
  static const GreyImage plain{1, 1, {0.0F}};
  std::vector<SmoothImage> images(camera.views.size(), SmoothImage(plain, 0));
  parallel_for(images.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const CameraView& view = camera.views[v];
      if (!is_usable(scene, camera.intrinsics, view)) continue;
      if (shown == Shown::contrast) {
        const GreyImage contrast = contrast_of(view.grey, halvings);
        images[v] = SmoothImage(contrast, halvings, spread_of(contrast), halvings);
      } else {
        images[v] = SmoothImage(view.grey, halvings, spread_of(view.grey));
      }
    }
  });
  return images;
}

}  // namespace rigcal
