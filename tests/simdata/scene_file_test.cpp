#include "simdata/scene_file.h"

#include <gtest/gtest.h>

namespace rigcal::sim {
namespace {

TEST(SceneFile, ReadsEveryBuiltInScene) {
  for (const std::string& name : builtin_scenes()) {
    const auto scene = load_scene(name);
    ASSERT_TRUE(scene.has_value()) << scene.error().message();
    EXPECT_EQ(scene->name, name);
    EXPECT_GT(scene->flats.size(), 100U) << name;
  }
}

}  // namespace
}  // namespace rigcal::sim
