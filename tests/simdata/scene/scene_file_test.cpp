#include "simdata/scene/scene_file.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace rigcal::sim {
namespace {

TEST(SceneFile, ReadsEveryBuiltInScene) {
  for (const std::string& name : builtin_scenes()) {
    const auto scene = load_scene(name);
    ASSERT_TRUE(scene.has_value()) << scene.error().message();
    EXPECT_EQ(scene->name, name);
    EXPECT_GT(scene->flats.size(), 100U) << name;
    const bool has_special = name == "glass_room" || name == "wet_yard";
    EXPECT_EQ(has_special, std::any_of(scene->materials.begin(), scene->materials.end(),
                                       [](const Material& material) { return !material.is_plain(); }));
  }
}

const std::string frame = "rigcal: 1\nmaterials: {brick: 40}\nturntable: {position: [0, 0, 1]}\n";

std::string error_of(const std::string& text) {
  const auto scene = parse_scene(text, "s.yaml");
  return scene ? "no error" : scene.error().message();
}

TEST(SceneFile, NamesTheLineOfAnUnknownKeyAndTheNearestKnownOne) {
  const std::string message = error_of(frame + "objects:\n  - {shape: box, centre: [0, 0, 0], size: [1, 1, 1]}\n");
  EXPECT_NE(std::string::npos, message.find("s.yaml:5")) << message;
  EXPECT_NE(std::string::npos, message.find("'center'")) << message;
}

TEST(SceneFile, RefusesWhatMakesNoSense) {
  const auto object = [](const std::string& text) { return error_of(frame + "objects:\n  - {" + text + "}\n"); };
  EXPECT_NE(std::string::npos, object("shape: cone").find("cone"));
  EXPECT_NE(std::string::npos,
            object("shape: box, center: [0, 0, 0], size: [1, 1, 1], material: brik").find("did you mean 'brick'"));
  EXPECT_NE(std::string::npos, object("shape: box, center: [0, 0, 0], size: [1, 0, 1], material: brick").find("size"));
  EXPECT_NE(std::string::npos, object("shape: panel, corner: [0, 0, 0], edge_a: [1, 0, 0], edge_b: [2, 0, 0], "
                                      "material: brick")
                                   .find("parallel"));
  EXPECT_NE(std::string::npos, error_of(frame + "people:\n  - {path: [0, 0, 0, 0], material: brick}\n").find("path"));
  EXPECT_NE(std::string::npos, error_of("rigcal: 1\nmaterials: {brick: 400}\n").find("brick"));
  EXPECT_NE(std::string::npos, error_of("rigcal: 1\nmaterials: {brick: 40}\n").find("turntable"));
}

TEST(SceneFile, ReadsWhatMaterialsDoWithTheLight) {
  const auto scene = parse_scene(
      "rigcal: 1\nmaterials: {brick: 40, pane: {reflectivity: 8, glass: 0.85}, water: {reflectivity: 20, wet: 1}, "
      "silver: {reflectivity: 5, mirror: 0.9}}\nturntable: {position: [0, 0, 1]}\n",
      "s.yaml");
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  ASSERT_EQ(4U, scene->materials.size());
  EXPECT_TRUE(scene->materials[0].is_plain());
  EXPECT_EQ(0.85, scene->materials[1].glass);
  EXPECT_EQ(8.0, scene->materials[1].reflectivity);
  EXPECT_EQ(1.0, scene->materials[2].wet);
  EXPECT_EQ(0.9, scene->materials[3].mirror);
  const auto refusal = [](const std::string& material) {
    return error_of("rigcal: 1\nmaterials:\n  odd: {" + material + "}\nturntable: {position: [0, 0, 1]}\n");
  };
  EXPECT_NE(std::string::npos, refusal("reflectivity: 8, glas: 0.5").find("'glass'"));
  EXPECT_NE(std::string::npos, refusal("reflectivity: 8, glass: 1.5").find("glass"));
  EXPECT_NE(std::string::npos, refusal("glass: 0.5").find("reflectivity"));
  EXPECT_NE(std::string::npos, refusal("reflectivity: 8, glass: 0.5, wet: 0.5").find("more than one"));
}

TEST(SceneFile, ReadsWhatSurfacesLookLikeAndTheLight) {
  const auto scene = parse_scene(
      "rigcal: 1\nmaterials: {soot: 1, wall: {reflectivity: 62, texture: brick, pattern: 0.2, color: [0.4, 0.2, "
      "0.1]}}\n"
      "light: {azimuth_deg: 90, elevation_deg: 0, sun: 2, ambient: 0.5, lamps: [1, 2, 3, 4, 5, 6, 7, 8]}\n"
      "turntable: {position: [0, 0, 1]}\n",
      "s.yaml");
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  EXPECT_EQ(Texture::plain, scene->materials[0].texture);
  EXPECT_NEAR(0.03, scene->materials[0].color[0], 1e-6);  // never quite black
  EXPECT_EQ(Texture::brick, scene->materials[1].texture);
  EXPECT_EQ(0.2, scene->materials[1].pattern_m);
  EXPECT_NEAR(0.1, scene->materials[1].color[2], 1e-6);
  EXPECT_LT((scene->light.to_sun() - Vector3d::UnitY()).norm(), 1e-12);
  ASSERT_EQ(2U, scene->light.lamps.size());
  EXPECT_EQ(8.0, scene->light.lamps[1].strength);
  const auto refusal = [](const std::string& material, const std::string& light) {
    return error_of("rigcal: 1\nmaterials:\n  odd: {reflectivity: 8, " + material + "}\nlight: {" + light +
                    "}\nturntable: {position: [0, 0, 1]}\n");
  };
  EXPECT_NE(std::string::npos, refusal("texture: brik", "").find("did you mean 'brick'"));
  EXPECT_NE(std::string::npos, refusal("texture: zzzzzzz", "").find("use one of plain, brick"));
  EXPECT_NE(std::string::npos, refusal("color: [1, 2, 0]", "").find("color"));
  EXPECT_NE(std::string::npos, refusal("pattern: 0", "").find("pattern"));
  EXPECT_NE(std::string::npos, refusal("wet: 1", "lamps: [1, 2, 3, 4, 5]").find("four numbers"));
  EXPECT_NE(std::string::npos, refusal("wet: 1", "lamps: [1, 2, 3, -4]").find("below zero"));
  EXPECT_NE(std::string::npos, refusal("wet: 1", "sun: -1").find("sun"));
}

TEST(SceneFile, RefusesCopiesThatWouldFillTheMemory) {
  const std::string message = error_of(
      frame +
      "objects:\n  - {shape: foliage, center: [0, 0, 0], radii: [1, 1, 1], leaves: 50000, leaf_size: [0.1, 0.2], "
      "material: brick, copies: {count: 50000, step: [1, 0, 0]}}\n");
  EXPECT_NE(std::string::npos, message.find("too many copies")) << message;
}

TEST(SceneFile, ListsTheScenesWhereANameIsNotKnown) {
  const auto scene = load_scene("courtyrad");
  ASSERT_FALSE(scene.has_value());
  EXPECT_NE(std::string::npos, scene.error().message().find("courtyard, room, sparse"));
}

TEST(SceneFile, CopiesAnObjectStepByStep) {
  const auto scene =
      parse_scene(frame +
                      "objects:\n  - {shape: cylinder, base: [1, 0, 0], length: 2, radius: 0.1, material: "
                      "brick, copies: {count: 3, step: [0, 2, 0]}}\n",
                  "s.yaml");
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  ASSERT_EQ(3U, scene->cylinders.size());
  EXPECT_EQ(6U, scene->flats.size());
  EXPECT_NEAR(4.0, scene->cylinders[2].base.y(), 1e-12);
}

}  // namespace
}  // namespace rigcal::sim
