#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/random.h"
#include "core/camera/camera_calibration.h"
#include "core/rig/camera_model.h"

namespace rigcal {

/// A room of 8 x 6 x 3 m with painted walls and a cupboard in it, the map of it and the images of a camera that looks
/// forward at some stops that a full turn is divided into. Paint is as bright for the camera as for the LiDAR; light
/// falls on each wall in another way. Where it is not painted, the LiDAR has no reflectivity either.
struct TexturedRoom {
  CameraScene scene;
  CameraTask camera;
  SE3 truth;
};

namespace textured_room {

struct Hit {
  double range_m = std::numeric_limits<double>::infinity();
  Vector3d normal = Vector3d::Zero();
  Vector3d p = Vector3d::Zero();
};

inline const std::array<Vector3d, 2> walls{Vector3d(-4.0, -3.0, -1.2), Vector3d(4.0, 3.0, 1.8)};
inline const std::array<Vector3d, 2> cupboard{Vector3d(1.6, 0.4, -1.2), Vector3d(2.2, 1.6, 0.6)};

/// The first face of a box that a ray meets, seen from inside or outside.
inline void meet(const std::array<Vector3d, 2>& box, bool inside, const Vector3d& from, const Vector3d& ray, Hit& hit) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const Vector3d outwards = (side == 0 ? -1.0 : 1.0) * Vector3d::Unit(axis);
      if ((ray.dot(outwards) > 0.0) != inside) continue;
      const double range = (box[static_cast<std::size_t>(side)][axis] - from[axis]) / ray[axis];
      const Vector3d p = from + range * ray;
      bool within = range > 0.0 && range < hit.range_m;
      for (int other = 0; other < 3; ++other) {
        within = within && (other == axis || (p[other] >= box[0][other] && p[other] <= box[1][other]));
      }
      if (within) hit = {range, inside ? Vector3d(-outwards) : outwards, p};
    }
  }
}

/// Paint in fields of 35 cm, 0 .. 1.
inline double paint(const Vector3d& p, const Vector3d& normal) {
  const auto field = [](double x) { return static_cast<std::uint64_t>(std::floor(x / 0.35) + 100.0); };
  const Vector3d q = p - 0.01 * normal;
  return Random(field(q.x()) << 16 | field(q.y()) << 8 | field(q.z())).uniform();
}

inline double light(const Vector3d& normal) { return 0.75 + 0.25 * normal.dot(Vector3d(0.6, 0.64, 0.48)); }

inline GreyImage render(const CameraModel& model, const SE3& T_G_camera, bool painted) {
  GreyImage image{model.intrinsics().width, model.intrinsics().height, {}};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      // Four rays a pixel.
      double sum = 0.0;
      for (int k = 0; k < 4; ++k) {
        const Vector3d ray = T_G_camera.R * *model.ray({x - 0.25 + 0.5 * (k % 2), y - 0.25 + 0.5 * (k / 2)});
        Hit hit;
        meet(walls, true, T_G_camera.t, ray, hit);
        meet(cupboard, false, T_G_camera.t, ray, hit);
        sum += (painted ? paint(hit.p, hit.normal) : 0.8) * light(hit.normal);
      }
      image.values.push_back(static_cast<float>(20.0 + 50.0 * sum));
    }
  }
  return image;
}

constexpr double spacing_m = 0.05;

/// Samples of all faces.
inline std::vector<MapSample> map_of_room(Random& random) {
  std::vector<MapSample> samples;
  const auto add_faces = [&](const std::array<Vector3d, 2>& box, bool inside) {
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < 2; ++side) {
        // One somewhere in each square, as a map has one in each cube.
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        Vector3d p = Vector3d::Zero();
        p[axis] = box[static_cast<std::size_t>(side)][axis];
        for (double x = box[0][u]; x < box[1][u]; x += spacing_m) {
          for (double y = box[0][v]; y < box[1][v]; y += spacing_m) {
            p[u] = std::min(box[1][u], x + spacing_m * random.uniform());
            p[v] = std::min(box[1][v], y + spacing_m * random.uniform());
            const Vector3d normal = ((side == 0) == inside ? 1.0 : -1.0) * Vector3d::Unit(axis);
            MapSample sample;
            sample.p_G = p.cast<float>();
            sample.normal_G = normal.cast<float>();
            sample.reflectivity = static_cast<std::uint8_t>(30.0 + 180.0 * paint(p, normal));
            samples.push_back(sample);
          }
        }
      }
    }
  };
  add_faces(walls, true);
  add_faces(cupboard, false);
  // Not wall by wall: maps leap, too.
  for (std::size_t k = samples.size(); k > 1; --k) std::swap(samples[k - 1], samples[random.below(k)]);
  return samples;
}

}  // namespace textured_room

[[nodiscard]] inline TexturedRoom make_textured_room(bool painted = true, int stops = 4) {
  Random random(11);
  TexturedRoom room;
  room.scene.samples = textured_room::map_of_room(random);
  if (!painted) {
    for (MapSample& sample : room.scene.samples) sample.reflectivity = 0;
  }
  Matrix3d optical;  // x right, y down, z forward in a rig's x forward, y left, z up
  optical << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  room.truth = {exp_so3({0.02, -0.03, 0.01}) * optical, {0.05, 0.04, -0.03}};
  room.camera.name = "camera";
  room.camera.intrinsics = {DistortionModel::radtan, 320, 240, 220.0, 220.0, 159.5, 119.5, {-0.1, 0.02, 0.0, 0.0, 0.0}};
  room.scene.turn = RigTurn{};
  const CameraModel model(room.camera.intrinsics);
  for (int j = 0; j < stops; ++j) {
    const double away = 4.0 * j / stops;
    room.scene.T_G_base.push_back({exp_so3({0.0, 0.0, 2.0 * pi * j / stops}), {0.1 * away, -0.05 * away, 0.0}});
    room.scene.stop_known.push_back(1);
    room.camera.views.push_back(
        {j, "", textured_room::render(model, room.scene.T_G_base.back() * room.truth, painted)});
  }
  return room;
}

}  // namespace rigcal
