#include "simdata/camera/image_renderer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/parallel.h"
#include "simdata/camera/image_sensor.h"
#include "simdata/scene/random_vectors.h"
#include "simdata/scene/scene_file.h"
#include "simdata/scene/scene_shapes.h"

namespace rigcal::sim {
namespace {

CameraIntrinsics intrinsics_of(DistortionModel model) {
  CameraIntrinsics intrinsics;
  intrinsics.model = model;
  intrinsics.width = 320;
  intrinsics.height = 256;
  intrinsics.fx = 216.0;
  intrinsics.fy = 214.0;
  intrinsics.cx = 161.3;
  intrinsics.cy = 126.1;
  intrinsics.distortion = model == DistortionModel::radtan ? std::vector<double>{-0.21, 0.07, 1.3e-3, -2e-3, -0.01}
                                                           : std::vector<double>{0.03, -0.01, 0.004, -0.001};
  return intrinsics;
}

/// Light from everywhere only, and materials that scatter these shares of it.
Scene scene_in_ambient_light(std::initializer_list<float> shares) {
  Scene scene;
  scene.light.sun = 0.0;
  scene.light.ambient = 1.0;
  for (const float share : shares) {
    Material material;
    material.color = Color::Constant(share);
    scene.materials.push_back(material);
  }
  return scene;
}

SE3 looking_down(double height) {
  Matrix3d R;  // x right is x, y down is -y, forward is down
  R.col(0) = Vector3d::UnitX();
  R.col(1) = -Vector3d::UnitY();
  R.col(2) = -Vector3d::UnitZ();
  return {R, Vector3d(0.0, 0.0, height)};
}

Eigen::Vector2d centroid(const LightField& light) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weight = 0.0;
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) {
      const auto value = static_cast<double>(light.at(x, y).sum());
      sum += value * Eigen::Vector2d(x, y);
      weight += value;
    }
  }
  return sum / weight;
}

// A white square of 6 pixels before a black wall, at many places of the image.
TEST(ImageRenderer, PutsAPointWhereTheCameraModelPutsIt) {
  for (const DistortionModel model : {DistortionModel::radtan, DistortionModel::equidistant}) {
    const CameraModel camera(intrinsics_of(model));
    const SE3 T_scene_camera{exp_so3(Vector3d(0.4, -1.1, 0.7)), Vector3d(3.0, -2.0, 1.0)};
    double worst = 0.0;
    for (const auto& [u, v] : {std::pair{160.0, 128.0},
                               {20.4, 15.2},
                               {301.7, 20.6},
                               {15.3, 240.5},
                               {298.2, 238.1},
                               {161.5, 12.25},
                               {80.75, 200.0}}) {
      const Vector3d p_camera = 4.0 * *camera.ray({u, v});
      Scene scene = scene_in_ambient_light({0.0F, 1.0F});
      const Vector3d p = T_scene_camera * p_camera;
      // Square across the line of sight, so that its middle stays in the middle.
      const Vector3d away = (p - T_scene_camera.t).normalized();
      const Vector3d side = away.unitOrthogonal();
      scene.flats.push_back({p, 0.055 * side, 0.055 * away.cross(side), false, 1});
      add_box(scene, {T_scene_camera.R, T_scene_camera.t}, Vector3d::Constant(40.0), 0);
      const RayCaster caster(scene);
      const LightField light = ImageRenderer(scene, caster, camera).render(T_scene_camera, 0.0);
      worst = std::max(worst, (centroid(light) - *camera.project(p_camera)).norm());
    }
    EXPECT_LT(worst, 0.1);
  }
}

// The place along a row at which the light crosses the middle between two pixels, to sub-pixel.
double crossing(const LightField& light, int y, int from, int to) {
  const float half = 0.5F * (light.at(from, y)[1] + light.at(to, y)[1]);
  for (int x = from; x < to; ++x) {
    const float a = light.at(x, y)[1] - half;
    const float b = light.at(x + 1, y)[1] - half;
    if (a * b <= 0.0F) return x + static_cast<double>(a / (a - b));
  }
  return -1.0;
}

TEST(ImageRenderer, CastsShadowsWhereTheSunAndTheLampsSay) {
  CameraIntrinsics intrinsics = intrinsics_of(DistortionModel::radtan);
  intrinsics.distortion = {0.0, 0.0, 0.0, 0.0, 0.0};
  const CameraModel camera(intrinsics);
  const SE3 T_scene_camera = looking_down(10.0);
  Scene scene = scene_in_ambient_light({0.8F});
  scene.has_ground = true;
  // A plate of 1 x 1 m, 1 m up.
  add_rectangle(scene, {Matrix3d::Identity(), Vector3d(2.0, 0.0, 1.0)}, 1.0, 1.0, 0);
  const auto pixel_of = [&](double x) { return *camera.project(T_scene_camera.inverse() * Vector3d(x, 0.0, 0.0)); };
  const int row = static_cast<int>(std::round(pixel_of(0.0).y()));
  const auto shadow_edges = [&] {
    const RayCaster caster(scene);
    const LightField light = ImageRenderer(scene, caster, camera).render(T_scene_camera, 0.0);
    const int dark = static_cast<int>(pixel_of(0.75).x());
    return std::pair{crossing(light, row, static_cast<int>(pixel_of(-1.5).x()), dark), light.at(dark, row)[1]};
  };
  // From +x at 45 degrees: the shadow reaches from 0.5 to 1.5.
  scene.light.sun = 1.0;
  scene.light.ambient = 0.2;
  scene.light.sun_azimuth_rad = 0.0;
  scene.light.sun_elevation_rad = to_rad(45.0);
  const auto [sun_edge, sun_dark] = shadow_edges();
  EXPECT_NEAR(pixel_of(0.5).x(), sun_edge, 0.6);
  // In it there is nothing but the light from everywhere.
  EXPECT_NEAR(0.8 * 0.2 * 0.96, sun_dark, 0.03);
  // A lamp 3 m up above x = 4: the plate's near edge at 1.5 is thrown to 0.25.
  scene.light.sun = 0.0;
  scene.light.lamps = {{Vector3d(4.0, 0.0, 3.0), 30.0}};
  EXPECT_NEAR(pixel_of(0.25).x(), shadow_edges().first, 0.6);
}

TEST(ImageRenderer, SeesThroughPanesAndIntoMirrors) {
  CameraIntrinsics intrinsics = intrinsics_of(DistortionModel::radtan);
  const CameraModel camera(intrinsics);
  Scene scene = scene_in_ambient_light({0.8F, 0.0F, 0.0F});
  scene.materials[1].glass = 0.8;
  scene.materials[2].mirror = 0.9;
  scene.light.ambient = 1.0;
  const SE3 T_scene_camera = looking_down(0.0);
  const auto middle = [&] {
    const RayCaster caster(scene);
    return ImageRenderer(scene, caster, camera).render(T_scene_camera, 0.0).at(161, 126)[1];
  };
  add_rectangle(scene, {Matrix3d::Identity(), Vector3d(0.0, 0.0, -5.0)}, 8.0, 8.0, 0);
  const float open = middle();
  add_rectangle(scene, {Matrix3d::Identity(), Vector3d(0.0, 0.0, -2.0)}, 4.0, 4.0, 1);
  // 8 % comes back from the pane and shows the sky above; the rest of what is behind, weaker.
  EXPECT_GT(middle(), 0.8F * 0.9F * open);
  scene.flats.back().material = 2;
  add_rectangle(scene, {Matrix3d::Identity(), Vector3d(0.0, 0.0, 3.0)}, 9.0, 9.0, 1);
  scene.materials[1] = scene.materials[0];
  scene.materials[1].color = Color(0.0F, 0.5F, 0.0F);
  const RayCaster caster(scene);
  const Color seen = ImageRenderer(scene, caster, camera).render(T_scene_camera, 0.0).at(161, 126);
  EXPECT_GT(seen[1], 0.1F);
  EXPECT_LT(seen[0], 1e-6F);
}

TEST(ImageRenderer, GivesTheSameBytesForAnyNumberOfThreads) {
  const auto scene = load_scene("room");
  ASSERT_TRUE(scene.has_value());
  const RayCaster caster(*scene);
  const CameraModel camera(intrinsics_of(DistortionModel::radtan));
  Sensor sensor;
  sensor.camera.emplace();
  sensor.camera->pixel_format = "BayerRG12";
  const auto chip = ImageSensor::of(sensor);
  ASSERT_TRUE(chip.has_value());
  const SE3 T_scene_camera{scene->T_scene_table.R * exp_so3(Vector3d(-1.6, 0.0, 0.0)), scene->T_scene_table.t};
  const auto image = [&](int threads) {
    set_thread_count(threads);
    return expose(ImageRenderer(*scene, caster, camera).render(T_scene_camera, 2.5), *chip, 3, 7);
  };
  const Image one = image(1);
  const Image two = image(2);
  const Image other_frame = expose(ImageRenderer(*scene, caster, camera).render(T_scene_camera, 2.5), *chip, 3, 8);
  EXPECT_TRUE(one.is_consistent());
  EXPECT_TRUE(one.bytes == two.bytes);
  EXPECT_FALSE(one.bytes == other_frame.bytes);
}

// What bundles of rays find is what single rays find.
TEST(RayBundle, FindsWhatSingleRaysFind) {
  for (const char* name : {"courtyard", "room"}) {
    const auto scene = load_scene(name);
    const RayCaster caster(*scene);
    const RayCaster::People people = caster.people_at(4.0);
    Random random(23);
    int hits = 0;
    int shadows = 0;
    int gathered = 0;
    constexpr double way = 12.0;
    for (int i = 0; i < 300; ++i) {
      const Vector3d origin = scene->T_scene_table.t + 0.3 * random_normal3(random);
      const Vector3d axis = random_direction(random);
      std::vector<Vector3d> rays;
      RayBundle bundle;
      bundle.origins.extend(origin);
      for (int k = 0; k < 8; ++k) {
        rays.push_back((axis + 0.01 * random_direction(random)).normalized());
        bundle.directions.extend(rays.back());
      }
      std::vector<RayCaster::Candidate> candidates;
      if (!caster.gather(bundle, 200, candidates)) continue;
      ++gathered;
      for (const Vector3d& ray : rays) {
        const auto single = caster.cast(origin, ray, people, 300.0);
        const auto bundled = caster.cast_among(candidates, origin, ray, people, 300.0);
        ASSERT_EQ(single.has_value(), bundled.has_value());
        if (!single) continue;
        ++hits;
        ASSERT_NEAR(single->range, bundled->range, 1e-9);
        // A way of 12 m is free unless something that is no ground stands on it.
        const bool blocked = caster.is_blocked(origin, way * ray, people);
        if (single->range > way || single->surface >= 0) {
          ASSERT_EQ(single->range < way, blocked);
        }
        shadows += blocked ? 1 : 0;
        ASSERT_EQ(blocked, caster.is_blocked_among(candidates, origin, way * ray, people));
      }
    }
    EXPECT_GT(gathered, 150) << name;
    EXPECT_GT(hits, 500) << name;
    EXPECT_GT(shadows, 20) << name;
  }
}

}  // namespace
}  // namespace rigcal::sim
