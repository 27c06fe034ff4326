#include "simdata/camera/image_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "simdata/scene/pattern_noise.h"
#include "simdata/scene/surface_optics.h"
#include "simdata/scene/surface_texture.h"

namespace rigcal::sim {
namespace {

constexpr double max_range = 2000.0;
constexpr std::size_t most_candidates = 200;
constexpr int most_meetings = 3;  // of a ray with panes and mirrors
constexpr double step = 1e-4;     // with which a ray goes on behind a surface

// A pane mirrors at both of its faces.
double pane_reflectance(double cos_incidence) {
  constexpr double head_on = 0.08;
  return head_on + (1.0 - head_on) * std::pow(1.0 - cos_incidence, 5.0);
}

Vector3d reflected(const Vector3d& direction, const Vector3d& normal) {
  return direction - 2.0 * normal.dot(direction) * normal;
}

// The i-th of n places in a pixel (n a power of two, at most 16): a Hammersley set, no two of which lie in one n-th of
// a column or row, shifted as a whole by an amount of the pixel's own.
Eigen::Vector2d ray_place(int i, int n, int x, int y) {
  const auto bits = static_cast<unsigned>(i);
  const unsigned reversed = (bits & 1U) << 3U | (bits & 2U) << 1U | (bits & 4U) >> 1U | (bits & 8U) >> 3U;
  const Eigen::Vector2d place(i / static_cast<double>(n) + cell_number(x, y, 71),
                              reversed / 16.0 + cell_number(x, y, 72));
  return place - place.array().floor().matrix();
}

}  // namespace

// What one ray of a pixel meets.
struct ImageRenderer::Sight {
  Vector3d direction = Vector3d::Zero();
  Vector3d point = Vector3d::Zero();
  Hit hit;
  bool any = false;
};

ImageRenderer::ImageRenderer(const Scene& scene, const RayCaster& caster, const CameraModel& camera)
    : scene_(scene),
      caster_(caster),
      light_(scene.light, caster),
      width_(camera.intrinsics().width),
      height_(camera.intrinsics().height),
      pixel_rad_(1.0 / std::sqrt(camera.intrinsics().fx * camera.intrinsics().fy)) {
  const auto columns = static_cast<std::size_t>(width_) + 1;
  const auto rows = static_cast<std::size_t>(height_) + 1;
  corners_.resize(columns * rows);
  parallel_for(rows, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y) {
      for (std::size_t x = 0; x < columns; ++x) {
        const auto ray = camera.ray({static_cast<double>(x) - 0.5, static_cast<double>(y) - 0.5});
        corners_[y * columns + x] = ray ? Eigen::Vector3f(ray->cast<float>())
                                        : Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
      }
    }
  });
}

LightField ImageRenderer::render(const SE3& T_scene_camera, double time_s) const {
  LightField out;
  out.width = width_;
  out.height = height_;
  out.pixels.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), Color::Zero());
  const View view{T_scene_camera, caster_.people_at(time_s)};
  const int tiles_x = (width_ + tile_px - 1) / tile_px;
  const int tiles_y = (height_ + tile_px - 1) / tile_px;
  parallel_for(static_cast<std::size_t>(tiles_y), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y)
      for (int x = 0; x < tiles_x; ++x) render_tile(view, x, static_cast<int>(y), out);
  });
  return out;
}

// The tile's pixels with the rays of each.
struct ImageRenderer::Tile {
  int x0 = 0;
  int y0 = 0;
  int x1 = 0;
  int y1 = 0;
  bool bundled = false;  ///< Whether `candidates` are all that its rays may meet.
  std::vector<RayCaster::Candidate> candidates;
  std::vector<Sight> sights;
  struct Pixel {
    std::size_t first = 0;  ///< In `sights`.
    std::size_t count = 0;
  };
  std::array<Pixel, tile_px * tile_px> pixels;

  Pixel& at(int x, int y) { return pixels[static_cast<std::size_t>((y - y0) * tile_px + x - x0)]; }
  [[nodiscard]] std::span<const Sight> rays(int x, int y) { return {sights.data() + at(x, y).first, at(x, y).count}; }
  // Whether rays of a pixel or of those beside it meet different surfaces.
  [[nodiscard]] bool has_edge(int x, int y) {
    const std::span<const Sight> own = rays(x, y);
    if (own.empty()) return false;
    const auto differs = [&](const Sight& other) {
      return other.any != own[0].any || (other.any && other.hit.surface != own[0].hit.surface);
    };
    for (const auto& [dx, dy] : {std::pair{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      if (x + dx < x0 || x + dx >= x1 || y + dy < y0 || y + dy >= y1) continue;
      const std::span<const Sight> near = rays(x + dx, y + dy);
      if (std::any_of(near.begin(), near.end(), differs)) return true;
    }
    return false;
  }
};

void ImageRenderer::look_through(const View& view, int x, int y, int count, Tile& tile) const {
  const Eigen::Vector3f& a = corner(x, y);
  const Eigen::Vector3f& b = corner(x + 1, y);
  const Eigen::Vector3f& c = corner(x, y + 1);
  const Eigen::Vector3f& d = corner(x + 1, y + 1);
  tile.at(x, y) = {tile.sights.size(), 0};
  if (!(a + b + c + d).allFinite()) return;
  tile.at(x, y).count = static_cast<std::size_t>(count);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2f place = ray_place(i, count, x, y).cast<float>();
    const float u = place.x();
    const float v = place.y();
    const Eigen::Vector3f ray = (1.0F - v) * ((1.0F - u) * a + u * b) + v * ((1.0F - u) * c + u * d);
    Sight& sight = tile.sights.emplace_back();
    sight.direction = (view.T_scene_camera.R * ray.cast<double>()).normalized();
    const auto hit = tile.bundled ? caster_.cast_among(tile.candidates, view.T_scene_camera.t, sight.direction,
                                                       view.people, max_range)
                                  : caster_.cast(view.T_scene_camera.t, sight.direction, view.people, max_range);
    if (!hit) continue;
    sight.any = true;
    sight.hit = *hit;
    sight.point = view.T_scene_camera.t + hit->range * sight.direction;
  }
}

void ImageRenderer::render_tile(const View& view, int tile_x, int tile_y, LightField& out) const {
  thread_local Tile tile;
  tile.x0 = tile_x * tile_px;
  tile.y0 = tile_y * tile_px;
  tile.x1 = std::min(tile.x0 + tile_px, width_);
  tile.y1 = std::min(tile.y0 + tile_px, height_);
  tile.sights.clear();
  RayBundle bundle;
  bundle.origins.extend(view.T_scene_camera.t);
  bundle.reach = max_range;
  for (int y = tile.y0; y <= tile.y1; ++y)
    for (int x = tile.x0; x <= tile.x1; ++x)
      if (corner(x, y).allFinite()) bundle.directions.extend(view.T_scene_camera.R * corner(x, y).cast<double>());
  if (bundle.directions.isEmpty()) return;
  // Rays between two corners bulge out a little beyond them.
  bundle.directions.min().array() -= 1e-4;
  bundle.directions.max().array() += 1e-4;
  tile.bundled = caster_.gather(bundle, most_candidates, tile.candidates);

  const auto each_pixel = [&](const auto& body) {
    for (int y = tile.y0; y < tile.y1; ++y)
      for (int x = tile.x0; x < tile.x1; ++x) body(x, y);
  };
  each_pixel([&](int x, int y) { look_through(view, x, y, pixel_rays, tile); });
  std::array<bool, tile_px * tile_px> edge{};
  const auto edge_at = [&](int x, int y) -> bool& {
    return edge[static_cast<std::size_t>((y - tile.y0) * tile_px + x - tile.x0)];
  };
  each_pixel([&](int x, int y) { edge_at(x, y) = tile.has_edge(x, y); });
  each_pixel([&](int x, int y) {
    if (edge_at(x, y)) look_through(view, x, y, edge_rays, tile);
  });

  thread_local SceneLight::Occluders occluders;
  Eigen::AlignedBox3d points;
  for (const Sight& sight : tile.sights)
    if (sight.any) points.extend(sight.point);
  if (!points.isEmpty()) light_.gather(points, occluders);
  const Vector3d axis = view.T_scene_camera.R.col(2);
  each_pixel([&](int x, int y) {
    const std::span<const Sight> rays = tile.rays(x, y);
    if (rays.empty()) return;
    const double cosine = std::max(0.0, axis.dot(rays.front().direction));
    out.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)] =
        shade_pixel(view, rays, occluders) * static_cast<float>(cosine * cosine);
  });
}

// Rays of one pixel that meet the same plain surface share its texture, which is an average over the pixel anyway;
// each asks for its own shadows.
Color ImageRenderer::shade_pixel(const View& view, std::span<const Sight> sights,
                                 const SceneLight::Occluders& occluders) const {
  Color sum = Color::Zero();
  std::array<bool, edge_rays> done{};
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const Sight& first = sights[i];
    if (done[i]) continue;
    if (!first.any) {
      sum += light_.sky(first.direction);
      continue;
    }
    if (!scene_.materials[static_cast<std::size_t>(first.hit.material)].is_plain()) {
      sum += light_from(view, view.T_scene_camera.t, first.direction, first.hit, most_meetings, 0.0);
      continue;
    }
    std::array<const Sight*, edge_rays> same{};
    std::size_t count = 0;
    for (std::size_t k = i; k < sights.size(); ++k) {
      if (done[k] || !sights[k].any || sights[k].hit.surface != first.hit.surface) continue;
      done[k] = true;
      same[count++] = &sights[k];
    }
    sum += scattered(view, {same.data(), count}, first.hit.range, &occluders) * static_cast<float>(count);
  }
  return sum / static_cast<float>(sights.size());
}

Color ImageRenderer::scattered(const View& view, std::span<const Sight* const> rays, double way,
                               const SceneLight::Occluders* occluders) const {
  const Hit& hit = rays.front()->hit;
  const Vector3d& direction = rays.front()->direction;
  const Material& material = scene_.materials[static_cast<std::size_t>(hit.material)];
  Vector3d point = Vector3d::Zero();
  for (const Sight* ray : rays) point += ray->point / static_cast<double>(rays.size());
  // A surface seen at a slant is larger than its pixel; the root stands between its two directions.
  const double cosine = std::max(0.15, std::abs(hit.normal.dot(direction)));
  const Look look = look_of(material, {point, hit.normal, caster_.place_on(hit, point, view.people), hit.surface,
                                       way * pixel_rad_ / std::sqrt(cosine)});
  Color irradiance = light_.ambient(hit.normal);
  for (std::size_t source = 0; source < light_.source_count(); ++source) {
    const Color direct = light_.direct(source, point, hit.normal, material.texture == Texture::leaves);
    if (!(direct.maxCoeff() > 0.0F)) continue;
    const auto reaches = [&](const Sight* ray) {
      return light_.reaches(source, ray->point, ray->hit.normal, view.people, occluders);
    };
    // Where the first, the middle and the last ray agree, the shadow's edge lies elsewhere.
    const bool first = reaches(rays.front());
    const bool even = rays.size() == 1 ||
                      (reaches(rays.back()) == first && (rays.size() <= 4 || reaches(rays[rays.size() / 2]) == first));
    const auto lit =
        even ? (first ? rays.size() : 0U) : static_cast<std::size_t>(std::count_if(rays.begin(), rays.end(), reaches));
    irradiance += direct * (static_cast<float>(lit) / static_cast<float>(rays.size()));
  }
  const Color light = look.color * irradiance;
  if (look.mirrored == 0.0) return light;
  const double share = std::min(1.0, look.mirrored * pane_reflectance(cosine) / pane_reflectance(1.0));
  return light + light_.sky(reflected(direction, hit.normal)) * static_cast<float>(share);
}

Color ImageRenderer::look_along(const View& view, const Vector3d& origin, const Vector3d& direction, int meetings,
                                double way) const {
  const auto hit = caster_.cast(origin, direction, view.people, max_range);
  if (!hit) return light_.sky(direction);
  return light_from(view, origin, direction, *hit, meetings, way);
}

Color ImageRenderer::light_from(const View& view, const Vector3d& origin, const Vector3d& direction, const Hit& hit,
                                int meetings, double way) const {
  const Material& material = scene_.materials[static_cast<std::size_t>(hit.material)];
  const Vector3d point = origin + hit.range * direction;
  const double whole = way + hit.range;
  const double cosine = std::abs(hit.normal.dot(direction));
  const auto mirrored = [&] {
    const Vector3d on = reflected(direction, hit.normal);
    return look_along(view, point + step * on, on, meetings - 1, whole);
  };
  const auto own = [&] {
    const Sight sight{direction, point, hit, true};
    const Sight* ray = &sight;
    return scattered(view, {&ray, 1}, whole, nullptr);
  };
  if (material.is_plain() || meetings == 0) return own();
  if (material.glass > 0.0) {
    const double back = pane_reflectance(cosine);
    const Color behind = look_along(view, point + step * direction, direction, meetings - 1, whole);
    return behind * static_cast<float>(material.glass * (1.0 - back)) + mirrored() * static_cast<float>(back);
  }
  if (material.mirror > 0.0)
    return mirrored() * static_cast<float>(material.mirror) + own() * static_cast<float>(1.0 - material.mirror);
  const double film = material.wet * water_reflectance(cosine);
  return mirrored() * static_cast<float>(film) + own() * static_cast<float>((1.0 - film) * (1.0 - 0.5 * material.wet));
}

}  // namespace rigcal::sim
