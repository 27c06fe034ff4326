#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/stops/still_listener.h"
#include "simdata/lidar/shot_meter.h"
#include "simdata/rig/imu_model.h"
#include "simdata/rig/sim_rig.h"
#include "simdata/scene/ray_caster.h"
#include "simdata/scene/scene_file.h"
#include "tests/core/stops/rig_motion.h"

namespace rigcal {

/// A turntable run of simulated LiDARs in memory: thinned, so that it costs little, and no more than the points.
class PointRun {
 public:
  struct Options {
    std::string scene = "room";
    std::uint64_t seed = 1;
    sim::TurntableOptions turntable;
    std::vector<std::size_t> lidars = {0, 1};  ///< Of the nominal rig: an AVIA and three MID-40.
    double shots_per_s = 20'000.0;             ///< Of each, about.
    double lead_s = 0.0;                       ///< Left out at the beginning and at the end.
    double tail_s = 0.0;
    std::optional<sim::Scene> own_scene = std::nullopt;  ///< Instead of `scene`.
  };
  static constexpr double batch_s = 0.005;

  explicit PointRun(const Options& options)
      : options_(options),
        scene_(options.own_scene ? *options.own_scene : *sim::load_scene(options.scene)),
        rig_(*sim::make_simulated_rig(sim::nominal_rig(), scene_.T_scene_table, options.turntable, {}, options.seed)) {}

  [[nodiscard]] const sim::TurntableMotion& motion() const { return rig_.motion; }
  [[nodiscard]] double end_s() const { return rig_.motion.duration_s() - options_.tail_s; }

  /// As the rough extrinsics of a rig file give it.
  [[nodiscard]] std::map<int, Vector3d> turn_axes() const {
    std::map<int, Vector3d> axes;
    for (const std::size_t i : options_.lidars) {
      axes[rig_.lidars[i].sensor] = rig_.lidars[i].T_base_sensor.R.transpose() * Vector3d::UnitZ();
    }
    return axes;
  }

  /// The readings of the AVIA's inertial unit, 200 a second.
  [[nodiscard]] std::vector<ImuSample> imu() const {
    Random random(options_.seed, 98);
    const sim::ImuModel unit(rig_.motion, SE3{}, sim::ImuErrors::draw(random));
    std::vector<ImuSample> samples;
    for (double t = options_.lead_s; t < end_s(); t += 0.005) {
      samples.push_back({0, to_stamp(t), unit.read_gyro(t, random), unit.read_accelerometer_g(t, random)});
    }
    return samples;
  }

  /// Hands batches to `take`, in order of time, LiDAR by LiDAR.
  template <typename Take>
  void play(Take&& take) const {
    const sim::RayCaster caster(scene_);
    Random random(options_.seed, 99);
    PointBatch batch;
    for (double t = options_.lead_s; t < end_s(); t += batch_s) {
      const sim::RayCaster::People people = caster.people_at(t);
      for (const std::size_t i : options_.lidars) {
        render(rig_.lidars[i], caster, people, t, random, batch);
        take(batch);
      }
    }
  }

 private:
  // The same points in any order of shots: strides that no scan line shares a factor with.
  void render(const sim::SimulatedLidar& lidar, const sim::RayCaster& caster, const sim::RayCaster::People& people,
              double t, Random& random, PointBatch& batch) const {
    const double rate = lidar.scanner.shots_per_s();
    const auto stride = static_cast<std::int64_t>(rate / options_.shots_per_s) / 2 * 2 + 1;
    const sim::ShotMeter meter(caster, scene_.materials, lidar.noise);
    const std::int64_t first = std::llround(t * rate) / stride;
    const std::int64_t end = std::llround((t + batch_s) * rate) / stride;
    batch.sensor = lidar.sensor;
    batch.stamp_ns = to_stamp(static_cast<double>(first * stride) / rate);
    batch.shot_interval_ns = 1e9 * static_cast<double>(stride) / rate;
    batch.shots = static_cast<std::uint16_t>(end - first);
    batch.points.clear();
    for (std::int64_t shot = first; shot < end; ++shot) {
      const SE3 T = rig_.motion.T_scene_base(static_cast<double>(shot * stride) / rate) * lidar.T_base_sensor;
      const sim::Shot measured = meter.measure(T, lidar.scanner.direction(shot * stride), people, random);
      if (measured.count == 0) continue;
      Point point = sim::to_point(measured.direction, measured.single(false));
      point.shot = static_cast<std::uint16_t>(shot - first);
      batch.points.push_back(point);
    }
  }

  Options options_;
  sim::Scene scene_;
  sim::SimulatedRig rig_;
};

/// When the swing after arriving has fallen to 0.1 mrad, s after the stop's start.
inline double settling_s(const sim::TurntableOptions& turntable) {
  return turntable.swing_rad <= 1e-4 ? 0.0 : turntable.swing_decay_s * std::log(1.5 * turntable.swing_rad / 1e-4);
}

/// How far the base is from its mean pose over a stop, at worst.
struct Deviation {
  double rotation_deg = 0.0;
  double translation_mm = 0.0;
};

inline Deviation deviation_in(const sim::TurntableMotion& motion, double start_s, double end_s) {
  const SE3 middle = motion.T_scene_base(0.5 * (start_s + end_s));
  std::vector<Vector6d> off;
  for (double t = start_s; t <= end_s; t += 0.002) {
    const SE3 X = middle.inverse() * motion.T_scene_base(t);
    off.emplace_back();
    off.back() << log_so3(X.R), X.t;
  }
  Vector6d mean = Vector6d::Zero();
  for (const Vector6d& x : off) mean += x / static_cast<double>(off.size());
  Deviation worst;
  for (const Vector6d& x : off) {
    worst.rotation_deg = std::max(worst.rotation_deg, to_deg((x - mean).head<3>().norm()));
    worst.translation_mm = std::max(worst.translation_mm, 1e3 * (x - mean).tail<3>().norm());
  }
  return worst;
}

}  // namespace rigcal
