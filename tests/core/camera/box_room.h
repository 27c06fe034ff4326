#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/camera/camera_calibration.h"
#include "core/rig/camera_model.h"

namespace rigcal {

/// A room with boxes in it, seen from a rig that turns in its middle: everything is known, images are cast ray by ray.
class BoxRoom {
 public:
  explicit BoxRoom(int stop_count = stops) {
    boxes_ = {{{-3.0, -2.6, -1.2}, {3.4, 2.4, 1.6}},  // the room itself, from within
              {{1.5, -1.9, -1.2}, {2.2, -1.1, 0.3}}, {{-2.4, 0.9, -1.2}, {-1.5, 1.7, -0.2}},
              {{0.4, 1.4, -1.2}, {1.3, 2.0, 0.6}},   {{-2.0, -2.2, -1.2}, {-1.2, -1.5, 0.1}},
              {{2.6, 0.6, -0.4}, {3.4, 1.5, 0.9}}};
    for (int j = 0; j < stop_count; ++j) {
      SE3 T;
      T.R = exp_so3(Vector3d(0.01 * j, -0.02, 2.0 * pi * j / stop_count));
      T.t = Vector3d(0.05 * std::cos(1.0 * j), 0.05 * std::sin(1.0 * j), 0.0);
      scene.T_G_base.push_back(T);
      scene.stop_known.push_back(1);
    }
    sample_surfaces();
    sample_edges();
  }

  static constexpr int stops = 8;
  CameraScene scene;

  [[nodiscard]] static CameraIntrinsics intrinsics() {
    return {DistortionModel::radtan, 480, 384, 320.0, 320.0, 239.5, 191.5, {-0.10, 0.09, 0.0003, -0.0002, 0.0}};
  }
  /// Looks forward (base x), as optical frames do: z forward, x right.
  [[nodiscard]] static SE3 truth() {
    SE3 T;
    T.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    T.R = T.R * exp_so3(Vector3d(0.03, -0.02, 0.04));
    T.t = Vector3d(0.05, -0.06, 0.03);
    return T;
  }
  [[nodiscard]] static SE3 spoiled(double rotation_rad, double translation_m, std::uint64_t seed) {
    Random random(seed);
    const auto direction = [&] {
      return Vector3d(Vector3d(random.normal(), random.normal(), random.normal()).normalized());
    };
    Vector6d xi;
    xi << rotation_rad * direction(), translation_m * direction();
    return truth() * SE3::exp(xi);
  }

  /// All images of the camera, with noise, and a guess that is off. `sway`: where the camera is at each second stop,
  /// or from the stop `from` on, seen from where it is at the others.
  [[nodiscard]] CameraTask task(const SE3& guess, std::uint64_t seed = 1, const SE3& sway = SE3{},
                                std::optional<int> from = {}) const {
    CameraTask task{0, "camera", intrinsics(), guess, {}};
    for (int j = 0; j < static_cast<int>(scene.T_G_base.size()); ++j) {
      const bool is_swayed = from ? j >= *from : j % 2 != 0;
      const SE3 T_base_camera = is_swayed ? truth() * sway : truth();
      task.views.push_back({j, std::to_string(j) + ".png", image(j, T_base_camera, seed)});
    }
    return task;
  }

  /// Distance along a ray in the world to the nearest surface.
  [[nodiscard]] double range(const Vector3d& from, const Vector3d& ray) const { return cast(from, ray).range; }

 private:
  struct Box {
    Vector3d low;
    Vector3d high;
  };
  struct Hit {
    double range = std::numeric_limits<double>::infinity();
    std::size_t box = 0;
    int face = 0;
  };

  [[nodiscard]] Hit cast(const Vector3d& from, const Vector3d& ray) const {
    Hit nearest;
    for (std::size_t b = 0; b < boxes_.size(); ++b) {
      double enter = -std::numeric_limits<double>::infinity();
      double leave = std::numeric_limits<double>::infinity();
      int enter_face = 0;
      int leave_face = 0;
      for (int k = 0; k < 3; ++k) {
        double a = (boxes_[b].low[k] - from[k]) / ray[k];
        double c = (boxes_[b].high[k] - from[k]) / ray[k];
        int first = 2 * k;
        int second = 2 * k + 1;
        if (a > c) {
          std::swap(a, c);
          std::swap(first, second);
        }
        if (a > enter) {
          enter = a;
          enter_face = first;
        }
        if (c < leave) {
          leave = c;
          leave_face = second;
        }
      }
      const double range = b == 0 ? leave : enter;
      if (enter > leave || range <= 0.0 || range >= nearest.range) continue;
      nearest = {range, b, b == 0 ? leave_face : enter_face};
    }
    return nearest;
  }

  // Each face has its own grey: faces that meet differ.
  [[nodiscard]] static float grey(const Hit& hit) {
    constexpr std::array<float, 6> faces{60.0F, 150.0F, 100.0F, 185.0F, 35.0F, 215.0F};
    return faces[static_cast<std::size_t>(hit.face)] + 7.0F * static_cast<float>(hit.box);
  }

  // Nine for each pixel, in the camera's frame: the same for all images, and half of the work.
  [[nodiscard]] static const std::vector<Vector3d>& all_rays() {
    static const std::vector<Vector3d> rays = [] {
      const CameraIntrinsics in = intrinsics();
      const CameraModel model(in);
      const auto width = static_cast<std::size_t>(in.width);
      std::vector<Vector3d> out(9 * width * static_cast<std::size_t>(in.height));
      parallel_for(out.size() / 9, 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t pixel = begin; pixel < end; ++pixel) {
          for (std::size_t k = 0; k < 9; ++k) {
            const double x = static_cast<double>(pixel % width) + (static_cast<double>(k % 3) - 1.0) / 3.0;
            const double y = static_cast<double>(pixel / width) + (static_cast<double>(k / 3) - 1.0) / 3.0;
            out[9 * pixel + k] = model.ray({x, y}).value();
          }
        }
      });
      return out;
    }();
    return rays;
  }

  [[nodiscard]] GreyImage image(int stop, const SE3& T_base_camera, std::uint64_t seed) const {
    const CameraIntrinsics in = intrinsics();
    const std::vector<Vector3d>& rays = all_rays();
    const SE3 T_G_C = scene.T_G_base[static_cast<std::size_t>(stop)] * T_base_camera;
    GreyImage out{in.width, in.height,
                  std::vector<float>(static_cast<std::size_t>(in.width) * static_cast<std::size_t>(in.height))};
    parallel_for(static_cast<std::size_t>(in.height), 8, [&](std::size_t begin, std::size_t end) {
      for (std::size_t y = begin; y < end; ++y) {
        Random random(seed, static_cast<std::uint64_t>(stop) * 10000 + y);
        for (int x = 0; x < in.width; ++x) {
          float sum = 0.0F;
          const std::size_t pixel = y * static_cast<std::size_t>(in.width) + static_cast<std::size_t>(x);
          for (std::size_t k = 0; k < 9; ++k) sum += grey(cast(T_G_C.t, T_G_C.R * rays[9 * pixel + k])) / 9.0F;
          out.values[pixel] = sum + 1.5F * static_cast<float>(random.normal());
        }
      }
    });
    return out;
  }

  void sample_surfaces() {
    constexpr double step = 0.05;
    for (const Box& box : boxes_) {
      for (int k = 0; k < 3; ++k) {
        const int u = (k + 1) % 3;
        const int v = (k + 2) % 3;
        for (double a = box.low[u]; a <= box.high[u]; a += step) {
          for (double b = box.low[v]; b <= box.high[v]; b += step) {
            for (const double c : {box.low[k], box.high[k]}) {
              Vector3d p;
              p[u] = a;
              p[v] = b;
              p[k] = c;
              MapSample sample;
              sample.p_G = p.cast<float>();
              scene.samples.push_back(sample);
            }
          }
        }
      }
    }
  }

  // The twelve edges of every box.
  void sample_edges() {
    int line = 0;
    for (const Box& box : boxes_) {
      for (int k = 0; k < 3; ++k) {
        const int u = (k + 1) % 3;
        const int v = (k + 2) % 3;
        for (int corner = 0; corner < 4; ++corner, ++line) {
          LidarEdge edge;
          edge.direction_G = Vector3d::Unit(k);
          edge.normal_a_G = Vector3d::Unit(u);
          edge.normal_b_G = Vector3d::Unit(v);
          edge.covariance_G = 1e-6 * (Matrix3d::Identity() - edge.direction_G * edge.direction_G.transpose());
          edge.line = line;
          edge.p_G[u] = corner % 2 != 0 ? box.high[u] : box.low[u];
          edge.p_G[v] = corner / 2 != 0 ? box.high[v] : box.low[v];
          for (double a = box.low[k] + 0.03; a < box.high[k] - 0.03; a += 0.025) {
            edge.p_G[k] = a;
            scene.edges.push_back(edge);
          }
        }
      }
    }
  }

  std::vector<Box> boxes_;
};

}  // namespace rigcal
