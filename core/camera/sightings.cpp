#include "core/camera/sightings.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/parallel.h"
#include "core/camera/depth_buffer.h"
#include "core/camera/sample_blocks.h"

namespace rigcal {
namespace {

// Of the samples that may be in view more than a quarter are seen, mostly.
constexpr std::size_t asked_per_sighting = 4;

// Largest angle from the axis at which a pixel of the image sees.
double half_view_rad(const CameraModel& model) {
  const double right = model.intrinsics().width - 1.0;
  const double bottom = model.intrinsics().height - 1.0;
  double largest = 0.0;
  for (const double x : {0.0, 0.5 * right, right}) {
    for (const double y : {0.0, 0.5 * bottom, bottom}) {
      const auto ray = model.ray({x, y});
      largest = std::max(largest, ray ? std::acos(std::clamp(ray->z(), -1.0, 1.0)) : model.max_angle_rad());
    }
  }
  return std::min(largest, model.max_angle_rad());
}

struct ViewJob {
  const CameraScene& scene;
  const CameraModel& model;
  const SE3 T_C_G;
  const SightingOptions& options;
  double cone_rad;
  std::size_t stride;

  // Calls `take(k)` for every sample that takes part and may be in the view.
  template <class Take>
  void for_each_near(const Take& take) const {
    const ViewCone cone(T_C_G, cone_rad);
    for_each_run(scene.samples.size(), scene.blocks, cone, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = first_from(begin, stride); k < end; k += stride) {
        if (cone.holds(scene.samples[k].p_G)) take(k);
      }
    });
  }
};

// The samples that one view sees, by their index; of those that may be in view every `asked_stride`-th is looked at.
std::vector<std::uint32_t> seen(const ViewJob& job, std::size_t asked_stride) {
  std::vector<MapSample> near;
  std::vector<std::uint32_t> index;
  job.for_each_near([&](std::size_t k) {
    near.push_back(job.scene.samples[k]);
    index.push_back(static_cast<std::uint32_t>(k));
  });
  DepthBufferOptions depth;
  depth.sample_m *= std::sqrt(static_cast<double>(job.stride));
  const DepthBuffer buffer(job.model, job.T_C_G, near, {}, depth);
  std::vector<std::uint32_t> visible;
  for (std::size_t k = 0; k < near.size(); k += asked_stride) {
    const Vector3d p_C = job.T_C_G * near[k].p_G.cast<double>();
    const auto pixel = job.model.project(p_C);
    if (!pixel || !job.model.contains(*pixel, job.options.margin_px)) continue;
    const double range_m = p_C.norm();
    if (!buffer.sees(*pixel, range_m, near[k])) continue;
    const int cells = job.options.silhouette_cells;
    if (cells > 0 && buffer.near_silhouette(*pixel, range_m, near[k], cells)) continue;
    visible.push_back(index[k]);
  }
  return visible;
}

}  // namespace

bool is_usable(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraView& view) {
  const GreyImage& grey = view.grey;
  return view.stop >= 0 && static_cast<std::size_t>(view.stop) < scene.T_G_base.size() &&
         scene.stop_known[static_cast<std::size_t>(view.stop)] && grey.width > 0 && grey.width == intrinsics.width &&
         grey.height > 0 && grey.height == intrinsics.height &&
         grey.values.size() == static_cast<std::size_t>(grey.width) * static_cast<std::size_t>(grey.height);
}

std::vector<Sighting> find_sightings(const CameraScene& scene, const SurfaceCodes& codes, const CameraTask& camera,
                                     const CameraModel& model, const SE3& T_base_camera,
                                     const SightingOptions& options) {
  const std::vector<CameraView>& views = camera.views;
  const std::size_t most = options.max_samples > 0 ? options.max_samples : scene.samples.size();
  const std::size_t stride =
      std::max<std::size_t>(1, (scene.samples.size() + most - 1) / std::max<std::size_t>(1, most));
  const double cone_rad = std::min(pi, half_view_rad(model) + to_rad(1.0));
  std::vector<std::vector<std::uint32_t>> visible(views.size());
  const auto for_each_view = [&](const auto& look) {
    parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        if (!is_usable(scene, camera.intrinsics, views[v])) continue;
        const auto stop = static_cast<std::size_t>(views[v].stop);
        look(v, ViewJob{scene, model, (scene.T_G_base[stop] * T_base_camera).inverse(), options, cone_rad, stride});
      }
    });
  };
  std::size_t asked_stride = 1;
  if (options.max_sightings > 0) {
    std::vector<std::size_t> near(views.size(), 0);
    for_each_view([&](std::size_t v, const ViewJob& job) { job.for_each_near([&](std::size_t) { ++near[v]; }); });
    const std::size_t all = std::accumulate(near.begin(), near.end(), std::size_t{0});
    asked_stride = std::max<std::size_t>(1, all / (asked_per_sighting * options.max_sightings));
  }
  for_each_view([&](std::size_t v, const ViewJob& job) { visible[v] = seen(job, asked_stride); });
  std::size_t total = 0;
  for (const auto& part : visible) total += part.size();
  const std::size_t wanted = options.max_sightings > 0 ? options.max_sightings : total;
  std::vector<Sighting> sightings;
  sightings.reserve(std::min(total, wanted));
  std::size_t count = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (visible[v].empty()) continue;
    const SE3 T_base_G = scene.T_G_base[static_cast<std::size_t>(views[v].stop)].inverse();
    for (const std::uint32_t k : visible[v]) {
      // Evenly `wanted` of `total`.
      const bool take = (count * wanted) / total != ((count + 1) * wanted) / total || wanted >= total;
      ++count;
      if (!take) continue;
      sightings.push_back({(T_base_G * scene.samples[k].p_G.cast<double>()).cast<float>(),
                           static_cast<std::uint16_t>(v), codes.of_sample[k]});
    }
  }
  return sightings;
}

CameraModel widened(const CameraModel& model, double margin_rad, double coarseness) {
  CameraIntrinsics wide;
  wide.model = DistortionModel::equidistant;
  const double focal = 0.5 * (model.intrinsics().fx + model.intrinsics().fy) / coarseness;
  const double half = focal * std::min(half_view_rad(model) + margin_rad, to_rad(175.0));
  wide.width = std::max(8, static_cast<int>(2.0 * half));
  wide.height = wide.width;
  wide.fx = focal;
  wide.fy = focal;
  wide.cx = 0.5 * (wide.width - 1);
  wide.cy = wide.cx;
  wide.distortion.assign(4, 0.0);
  return CameraModel(wide);
}

}  // namespace rigcal
