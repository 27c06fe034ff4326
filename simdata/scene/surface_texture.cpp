#include "simdata/scene/surface_texture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "simdata/scene/pattern_noise.h"

namespace rigcal::sim {
namespace {

constexpr std::array<std::pair<std::string_view, Texture>, 16> texture_words{{
    {"plain", Texture::plain},
    {"brick", Texture::brick},
    {"plaster", Texture::plaster},
    {"concrete", Texture::concrete},
    {"stone", Texture::stone},
    {"paving", Texture::paving},
    {"tiles", Texture::tiles},
    {"boards", Texture::boards},
    {"grass", Texture::grass},
    {"leaves", Texture::leaves},
    {"window", Texture::window},
    {"bars", Texture::bars},
    {"cloth", Texture::cloth},
    {"carton", Texture::carton},
    {"metal", Texture::metal},
    {"checker", Texture::checker},
}};

// Coordinates on a wall that go on from one part of it to the next: level along it, and up; x and y on level ground.
struct WallPlace {
  double along;
  double up;
};

WallPlace wall_place(const SurfacePoint& point) {
  const Vector3d& n = point.normal;
  if (std::abs(n.z()) > 0.97) return {point.p.x(), point.p.y()};
  const Vector3d along = Vector3d(-n.y(), n.x(), 0.0).normalized();
  return {point.p.dot(along), point.p.dot(n.cross(along))};
}

std::int64_t cell_of(double x, double size) { return static_cast<std::int64_t>(std::floor(x / size)); }

Look mix(const Look& a, const Look& b, double share_of_b) {
  const auto s = static_cast<float>(share_of_b);
  return {a.color + s * (b.color - a.color), a.reflectivity + share_of_b * (b.reflectivity - a.reflectivity),
          a.mirrored + share_of_b * (b.mirrored - a.mirrored)};
}

void shade(Look& look, double to_the_eye, double at_905_nm) {
  look.color *= static_cast<float>(std::max(0.1, 1.0 + to_the_eye));
  look.reflectivity *= std::max(0.1, 1.0 + at_905_nm);
}

double usual(const Material& material, double size) { return material.pattern_m > 0.0 ? material.pattern_m : size; }

Look brick(const Material& material, const SurfacePoint& point) {
  const auto [along, up] = wall_place(point);
  const double length = usual(material, 0.25);
  const double height = 0.3 * length;
  const double joint = 0.012 * length / 0.25;
  const std::int64_t course = cell_of(up, height);
  const double shifted = along + (course % 2 != 0 ? 0.5 * length : 0.0);
  const std::int64_t number = cell_of(shifted, length);
  const double left = contrast_left(height, point.footprint);
  const double tone = left * (cell_number(number, course, 1) - 0.5);
  const double other_tone = left * (cell_number(number, course, 2) - 0.5);
  Look look{material.color, 0.94, 0.0};
  shade(look, 0.7 * tone + 0.15 * other_tone, 0.2 * tone + 0.2 * other_tone);
  look.color.z() *= static_cast<float>(1.0 + 0.5 * other_tone);
  const double upright = line_share(shifted, length, joint, point.footprint);
  const double level = line_share(up, height, joint, point.footprint);
  look = mix(look, {{0.5F, 0.48F, 0.44F}, 1.25, 0.0}, upright + level - upright * level);
  const double soot = smooth_noise(point.p, 1.7, point.footprint);
  shade(look, 0.2 * soot, 0.07 * soot);
  return look;
}

// Posters, repairs and painted fields: at most one in each cell of a grid.
void add_patches(Look& look, const WallPlace& at, double cell, double share, const Material& material) {
  const std::int64_t column = cell_of(at.along, cell);
  const std::int64_t row = cell_of(at.up, cell);
  const auto number = [&](std::int64_t which) { return cell_number(column, row, 100 + which); };
  if (number(0) > share) return;
  const double half_width = cell * (0.1 + 0.25 * number(1));
  const double half_height = cell * (0.08 + 0.22 * number(2));
  const double x = at.along - (static_cast<double>(column) + 0.5 + 0.25 * (number(3) - 0.5)) * cell;
  const double y = at.up - (static_cast<double>(row) + 0.5 + 0.25 * (number(4) - 0.5)) * cell;
  if (std::abs(x) > half_width || std::abs(y) > half_height) return;
  const double grey = 0.1 + 0.45 * number(5);
  const Eigen::Array3f paint =
      Eigen::Array3d(grey + 0.3 * number(6), grey + 0.2 * number(7), grey + 0.2 * number(9)).cast<float>();
  const double brighter =
      static_cast<double>(paint.mean()) / std::max(0.05, static_cast<double>(material.color.mean()));
  look.color = paint;
  look.reflectivity *= std::clamp(1.0 + 0.35 * (brighter - 1.0) + 0.3 * (number(8) - 0.5), 0.4, 1.5);
}

Look plaster(const Material& material, const SurfacePoint& point) {
  Look look{material.color, 1.0, 0.0};
  if (std::abs(point.normal.z()) < 0.5) add_patches(look, wall_place(point), usual(material, 2.6), 0.3, material);
  const double stain = smooth_noise(point.p, 1.3, point.footprint);
  const double grain = smooth_noise(point.p, 0.05, point.footprint);
  shade(look, 0.12 * stain + 0.06 * grain, 0.05 * stain + 0.03 * grain);
  return look;
}

Look concrete(const Material& material, const SurfacePoint& point) {
  const auto [along, up] = wall_place(point);
  Look look{material.color, 1.02, 0.0};
  const double size = usual(material, 1.5);
  const double joint =
      std::max(line_share(along, size, 0.02, point.footprint), line_share(up, 0.7 * size, 0.02, point.footprint));
  shade(look, -0.6 * joint, -0.35 * joint);
  const double stain = smooth_noise(point.p, 0.8, point.footprint);
  const double speckle = smooth_noise(point.p, 0.025, point.footprint);
  shade(look, 0.2 * stain + 0.12 * speckle, 0.1 * stain + 0.05 * speckle);
  return look;
}

Look stone(const Material& material, const SurfacePoint& point) {
  Look look{material.color, 1.0, 0.0};
  const double vein = smooth_noise(point.p, usual(material, 0.22), point.footprint);
  const double speckle = smooth_noise(point.p, 0.018, point.footprint);
  shade(look, 0.22 * vein + 0.18 * speckle, 0.1 * vein + 0.07 * speckle);
  return look;
}

Look paving(const Material& material, const SurfacePoint& point) {
  const auto [along, up] = wall_place(point);
  const double slab = usual(material, 0.5);
  const double left = contrast_left(slab, point.footprint);
  const double tone = left * (cell_number(cell_of(along, slab), cell_of(up, slab), 11) - 0.5);
  Look look{material.color, 1.01, 0.0};
  const double across = line_share(along, slab, 0.015, point.footprint);
  const double joint = across + (1.0 - across) * line_share(up, slab, 0.015, point.footprint);
  shade(look, 0.35 * tone - 0.55 * joint, 0.16 * tone - 0.3 * joint);
  const double wear = smooth_noise(point.p, 2.4, point.footprint);
  shade(look, 0.2 * wear, 0.08 * wear);
  return look;
}

Look tiles(const Material& material, const SurfacePoint& point) {
  const auto [along, up] = wall_place(point);
  const double height = usual(material, 0.33);
  const double width = 0.75 * height;
  const double left = contrast_left(width, point.footprint);
  const double tone = left * (cell_number(cell_of(along, width), cell_of(up, height), 21) - 0.5);
  Look look{material.color, 1.05, 0.0};
  const double overlap = line_share(up, height, 0.05, point.footprint);
  const double seam = line_share(along, width, 0.02, point.footprint);
  shade(look, 0.4 * tone - 0.45 * overlap - 0.3 * seam, 0.15 * tone - 0.2 * overlap - 0.1 * seam);
  return look;
}

Look boards(const Material& material, const SurfacePoint& point) {
  const double width = usual(material, 0.14);
  // Along the longer side of the surface.
  const bool turned = point.place.half.x() > point.place.half.y();
  const double across = (turned ? point.place.at.y() : point.place.at.x()) +
                        0.5 * width;  // the middle of a board in the middle of the surface
  const double along = turned ? point.place.at.x() : point.place.at.y();
  const std::int64_t board = cell_of(across, width);
  const double left = contrast_left(width, point.footprint);
  const double tone = left * (cell_number(board, point.surface, 31) - 0.5);
  Look look{material.color, 1.02, 0.0};
  const double gap = line_share(across, width, 0.006, point.footprint);
  const double grain =
      smooth_noise({across / 0.012, along / 0.3, static_cast<double>(board)}, 1.0, point.footprint / 0.012);
  shade(look, 0.45 * tone - 0.75 * gap + 0.22 * grain, 0.12 * tone - 0.4 * gap + 0.04 * grain);
  return look;
}

Look grass(const Material& material, const SurfacePoint& point) {
  const double dry =
      smooth_noise(point.p, usual(material, 3.5), point.footprint) + 0.6 * smooth_noise(point.p, 0.9, point.footprint);
  const double tuft = smooth_noise(point.p, 0.12, point.footprint) + smooth_noise(point.p, 0.03, point.footprint);
  Look look{material.color, 1.0, 0.0};
  // Dry grass and earth are brighter to the eye and darker to the laser than green blades.
  look = mix(look, {{0.3F, 0.25F, 0.16F}, 0.65, 0.0}, std::clamp(0.5 + 0.8 * dry, 0.0, 1.0));
  shade(look, 0.35 * tuft, 0.12 * tuft);
  look.reflectivity *= 1.2;
  return look;
}

Look leaves(const Material& material, const SurfacePoint& point) {
  const double tone = cell_number(point.surface, 41, 0) - 0.5;
  const double other_tone = cell_number(point.surface, 42, 0) - 0.5;
  Look look{material.color, 1.0, 0.0};
  shade(look, 0.9 * tone, 0.1 * tone + 0.3 * other_tone);
  look.color.x() *= static_cast<float>(1.0 + 0.8 * other_tone);
  return look;
}

// A frame, a mullion and a transom before the pane; with iron bars where they are asked for.
Look window(const Material& material, const SurfacePoint& point, bool with_bars) {
  const Eigen::Vector2d& at = point.place.at;
  const Eigen::Vector2d& half = point.place.half;
  // Dust on the pane, which the eye looks through.
  Look look{{0.04F, 0.045F, 0.05F}, 0.55 + 0.15 * smooth_noise(point.p, 0.4, point.footprint), 0.35};
  const double f = std::max(point.footprint, 1e-6);
  // Share of the footprint beyond an edge at 0.
  const auto beyond = [f](double distance) { return std::clamp(0.5 + distance / f, 0.0, 1.0); };
  const auto strip = [&](double x, double middle, double width) {
    return beyond(x - middle + 0.5 * width) - beyond(x - middle - 0.5 * width);
  };
  const double border = usual(material, 0.07);
  const double transom = half.y() * 0.35;
  const double frame =
      std::max({beyond(std::abs(at.x()) - half.x() + border), beyond(std::abs(at.y()) - half.y() + border),
                strip(at.x(), 0.0, border), strip(at.y(), transom, 0.8 * border)});
  look = mix(look, {material.color, 2.3, 0.0}, frame);
  if (with_bars) {
    const double bars =
        std::max(line_share(at.x(), 0.14, 0.018, point.footprint), line_share(at.y(), 0.6, 0.03, point.footprint));
    look = mix(look, {{0.06F, 0.055F, 0.05F}, 1.2, 0.0}, bars);
  }
  return look;
}

Look cloth(const Material& material, const SurfacePoint& point) {
  const std::int64_t limb = point.surface;
  Look look{material.color, 1.0, 0.0};
  // Heads, the last part of a body, are no cloth.
  if (point.surface % Body::parts == Body::parts - 1) return {{0.45F, 0.3F, 0.22F}, 1.1, 0.0};
  for (int i = 0; i < 3; ++i) look.color[i] *= static_cast<float>(0.5 + cell_number(limb, 51, i));
  // Dyes that the eye tells apart look alike to the laser.
  look.reflectivity = 0.85 + 0.3 * cell_number(limb, 52, 0);
  if (cell_number(limb, 53, 0) < 0.5) {
    const double stripe = line_share(point.place.at.y(), usual(material, 0.09), 0.03, point.footprint);
    shade(look, 0.9 * stripe, 0.05 * stripe);
  }
  const double fold =
      smooth_noise({point.place.at.x(), point.place.at.y(), static_cast<double>(limb)}, 0.15, point.footprint);
  shade(look, 0.25 * fold, 0.05 * fold);
  return look;
}

// A tape along the middle, and a printed label in one corner.
Look carton(const Material& material, const SurfacePoint& point) {
  const Eigen::Vector2d& at = point.place.at;
  const Eigen::Vector2d& half = point.place.half;
  Look look{material.color, 0.97, 0.0};
  if (std::abs(at.y()) < 0.025) look = {{0.62F, 0.5F, 0.33F}, 1.05, 0.0};
  const auto number = [&](std::int64_t which) { return cell_number(point.surface, 60 + which, 0); };
  const Eigen::Vector2d corner(half.x() * (0.45 * (2.0 * number(0) - 1.0)), half.y() * (number(1) < 0.5 ? -0.5 : 0.5));
  const Eigen::Vector2d from = (at - corner).cwiseAbs().cwiseQuotient(half.cwiseMin(1.0));
  if (from.x() < 0.32 && from.y() < 0.28) {
    look = {{0.8F, 0.8F, 0.78F}, 1.3, 0.0};
    const double text = line_share(at.y() - corner.y(), 0.04, 0.016, point.footprint) *
                        (cell_number(cell_of(at.x(), 0.023), cell_of(at.y(), 0.04), point.surface) < 0.75 ? 1.0 : 0.0);
    shade(look, -0.85 * text, -0.25 * text);
  }
  const double wear = smooth_noise(point.p, 0.2, point.footprint);
  shade(look, 0.1 * wear, 0.05 * wear);
  return look;
}

Look metal(const Material& material, const SurfacePoint& point) {
  const auto [along, up] = wall_place(point);
  Look look{material.color, 1.0, 0.0};
  const double sheet = line_share(along, usual(material, 1.2), 0.02, point.footprint);
  const double rust = std::max(0.0, smooth_noise(point.p, 0.6, point.footprint) - 0.35) * 1.5;
  look = mix(look, {{0.25F, 0.12F, 0.06F}, 0.6, 0.0}, std::min(1.0, rust));
  const double brushed = smooth_noise({along / 0.5, up / 0.01, 0.0}, 1.0, point.footprint / 0.01);
  shade(look, 0.07 * brushed - 0.5 * sheet, 0.03 * brushed - 0.2 * sheet);
  return look;
}

Look checker(const Material& material, const SurfacePoint& point) {
  const double size = usual(material, 0.1);
  // Share of odd columns and of odd rows in the footprint.
  const double x = line_share(point.place.at.x() - 0.5 * size, 2.0 * size, size, point.footprint);
  const double y = line_share(point.place.at.y() - 0.5 * size, 2.0 * size, size, point.footprint);
  const Look dark{{0.05F, 0.05F, 0.05F}, 0.3, 0.0};
  return mix(dark, {material.color, 1.7, 0.0}, x * y + (1.0 - x) * (1.0 - y));
}

Look pattern_of(const Material& material, const SurfacePoint& point) {
  switch (material.texture) {
    case Texture::brick:
      return brick(material, point);
    case Texture::plaster:
      return plaster(material, point);
    case Texture::concrete:
      return concrete(material, point);
    case Texture::stone:
      return stone(material, point);
    case Texture::paving:
      return paving(material, point);
    case Texture::tiles:
      return tiles(material, point);
    case Texture::boards:
      return boards(material, point);
    case Texture::grass:
      return grass(material, point);
    case Texture::leaves:
      return leaves(material, point);
    case Texture::window:
      return window(material, point, false);
    case Texture::bars:
      return window(material, point, true);
    case Texture::cloth:
      return cloth(material, point);
    case Texture::carton:
      return carton(material, point);
    case Texture::metal:
      return metal(material, point);
    case Texture::checker:
      return checker(material, point);
    case Texture::plain:
      break;
  }
  return {material.color, 1.0, 0.0};
}

}  // namespace

Look look_of(const Material& material, const SurfacePoint& point) {
  Look look = pattern_of(material, point);
  look.color = look.color.max(0.0F).min(1.0F);
  return look;
}

std::optional<Texture> parse_texture(std::string_view name) {
  for (const auto& [word, texture] : texture_words)
    if (word == name) return texture;
  return std::nullopt;
}

std::vector<std::string> texture_names() {
  std::vector<std::string> names;
  for (const auto& [word, texture] : texture_words) names.emplace_back(word);
  return names;
}

}  // namespace rigcal::sim
