#include "simdata/scene/scene_looks.h"

#include <algorithm>
#include <utility>

#include "core/base/text.h"
#include "simdata/scene/surface_texture.h"

namespace rigcal::sim {
namespace {

constexpr std::size_t max_lamps = 16;

// What is not said to have a colour is grey, as bright as it is to the laser, but never quite black or white.
Eigen::Array3f grey_of(double reflectivity) {
  return Eigen::Array3f::Constant(static_cast<float>(std::clamp(reflectivity / 100.0, 0.03, 0.85)));
}

void read_texture(const YamlMap& map, Material& material) {
  if (const auto name = map.text("texture")) {
    const auto texture = parse_texture(*name);
    if (texture) {
      material.texture = *texture;
    } else {
      const std::string nearest = nearest_word(*name, texture_names());
      map.fail("texture", "there is no texture '" + *name + "'",
               nearest.empty() ? "use one of " + joined(texture_names(), ", ") : "did you mean '" + nearest + "'?");
    }
  }
  material.pattern_m = map.number("pattern", 0.01, 100.0).value_or(0.0);
  if (const auto color = map.numbers("color", 3, 3, 0.0, 1.0))
    material.color = Eigen::Array3d((*color)[0], (*color)[1], (*color)[2]).cast<float>();
}

// A reflectivity, or a map of it, one of glass, mirror, wet, and what it looks like.
Material read_material(const YamlMap& materials, const std::string& name) {
  Material material;
  material.name = name;
  if (materials.get(name)->kind != YamlNode::Kind::map) {
    material.reflectivity = materials.number(name, 0.0, 150.0).value_or(0.0);
    material.color = grey_of(material.reflectivity);
    return material;
  }
  const auto map = materials.map(name, {"reflectivity", "glass", "mirror", "wet", "texture", "pattern", "color"});
  if (!map) return material;
  if (map->require("reflectivity")) material.reflectivity = map->number("reflectivity", 0.0, 150.0).value_or(0.0);
  material.color = grey_of(material.reflectivity);
  read_texture(*map, material);
  int kinds = 0;
  for (const auto& [key, share] :
       {std::pair{"glass", &material.glass}, {"mirror", &material.mirror}, {"wet", &material.wet}}) {
    *share = map->number(key, 0.0, 1.0).value_or(0.0);
    kinds += *share > 0.0 ? 1 : 0;
  }
  if (kinds > 1) materials.fail(name, "the material is more than one of glass, mirror and wet", "keep one of them");
  return material;
}

}  // namespace

std::vector<Material> read_materials(const YamlMap& scene) {
  std::vector<Material> all;
  if (!scene.require("materials", "list them as name: reflectivity (0 .. 150)")) return all;
  const YamlNode* node = scene.get("materials");
  const YamlMap materials(*node, "materials", scene.errors(), {});
  for (const YamlKey& key : node->keys) all.push_back(read_material(materials, key.name));
  if (all.empty()) scene.fail("materials", "there is no material");
  return all;
}

Light read_light(const YamlMap& scene) {
  Light light;
  const auto map = scene.map("light", {"azimuth_deg", "elevation_deg", "sun", "ambient", "lamps"});
  if (!map) return light;
  if (const auto deg = map->number("azimuth_deg", -360.0, 360.0)) light.sun_azimuth_rad = to_rad(*deg);
  if (const auto deg = map->number("elevation_deg", -10.0, 90.0)) light.sun_elevation_rad = to_rad(*deg);
  light.sun = map->number("sun", 0.0, 100.0).value_or(light.sun);
  light.ambient = map->number("ambient", 0.0, 100.0).value_or(light.ambient);
  // x, y, z and strength, lamp after lamp.
  const auto lamps = map->numbers("lamps", 4, 4 * max_lamps, -1e4, 1e4);
  if (!lamps) return light;
  if (lamps->size() % 4 != 0) map->fail("lamps", "each lamp takes four numbers", "write x, y, z, strength, x, ...");
  for (std::size_t i = 0; i + 3 < lamps->size(); i += 4) {
    if ((*lamps)[i + 3] < 0.0) map->fail("lamps", "a lamp's strength is below zero");
    light.lamps.push_back({Vector3d((*lamps)[i], (*lamps)[i + 1], (*lamps)[i + 2]), (*lamps)[i + 3]});
  }
  return light;
}

}  // namespace rigcal::sim
