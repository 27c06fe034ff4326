#pragma once

#include <gtest/gtest.h>

#include <string>

#include "simdata/scene/scene_file.h"

/// Scenes of a few flat surfaces, as objects of a scene file.
namespace rigcal {

/// An upright rectangle facing along the level direction `facing_deg`, its foot on the ground.
inline std::string wall(double x, double y, double width, double height, double facing_deg) {
  return "  - {shape: rectangle, center: [" + std::to_string(x) + ", " + std::to_string(y) + ", " +
         std::to_string(0.5 * height) + "], size: [" + std::to_string(height) + ", " + std::to_string(width) +
         "], rpy_deg: [0, 90, " + std::to_string(facing_deg) + "], material: grey}\n";
}

inline std::string ceiling(double height, double length, double width) {
  return "  - {shape: rectangle, center: [0, 0, " + std::to_string(height) + "], size: [" + std::to_string(length) +
         ", " + std::to_string(width) + "], material: grey}\n";
}

/// Four walls and a ceiling about the origin.
inline std::string walls_of_room(double length, double width, double height) {
  return wall(0.0, 0.5 * width, length, height, 90.0) + wall(0.0, -0.5 * width, length, height, 90.0) +
         wall(0.5 * length, 0.0, width, height, 0.0) + wall(-0.5 * length, 0.0, width, height, 0.0) +
         ceiling(height, length, width);
}

/// `table`: "x, y" of the turntable.
inline sim::Scene bare_scene(const std::string& objects, bool with_ground, const std::string& table) {
  const std::string text = std::string("rigcal: 1\nname: bare\nmaterials:\n  grey: {reflectivity: 50}\n") +
                           "turntable: {position: [" + table + ", 1.22], yaw_deg: -11}\n" +
                           (with_ground ? "ground: {height: 0, material: grey}\n" : "") + "objects:\n" + objects;
  const Expected<sim::Scene> scene = sim::parse_scene(text, "bare.yaml");
  EXPECT_TRUE(scene) << scene.error().message();
  return scene ? *scene : sim::Scene{};
}

}  // namespace rigcal
