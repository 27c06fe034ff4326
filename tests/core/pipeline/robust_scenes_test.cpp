#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "core/geometry/symmetric_solve.h"
#include "tests/core/pipeline/bare_scenes.h"
#include "tests/support/light_recording.h"
#include "tests/support/noting_reporter.h"

namespace rigcal {
namespace {

using testing::Contains;
using testing::HasSubstr;

struct Calibrated {
  LightRecording run;
  CalibrationResult result;
  std::vector<std::string> warnings;

  [[nodiscard]] double error_m(std::size_t lidar) const {
    return (result.sensors[lidar].T_base_sensor->t - run.truth.T_base_sensor[lidar].t).norm();
  }
  // Right to `bound_m` and 0.1 degrees, or flagged.
  void expect_right_or_flagged(double bound_m) const {
    for (std::size_t i = 1; i < result.sensors.size(); ++i) {
      if (result.sensors[i].status != Status::good) continue;
      EXPECT_LT(error_m(i), bound_m) << result.sensors[i].name;
      EXPECT_LT(rotation_distance(result.sensors[i].T_base_sensor->R, run.truth.T_base_sensor[i].R), to_rad(0.1));
    }
  }
  void expect_all_good() const {
    for (const SensorResult& sensor : result.sensors) {
      EXPECT_EQ(sensor.status, Status::good) << sensor.name << testing::PrintToString(sensor.reasons);
    }
  }
};

Calibrated calibrate(const sim::LightRig& light) {
  Calibrated out{make_light_recording(light), {}, {}};
  NotingReporter reporter;
  const auto result = calibrate_lidars(out.run.rig, out.run.recording, out.run.guess, {}, RunContext{reporter});
  EXPECT_TRUE(result) << result.error().message();
  if (result) out.result = *result;
  out.warnings = reporter.warnings;
  return out;
}

sim::LightRigOptions usual() {
  sim::LightRigOptions options;
  options.seed = 31;
  options.turntable.stops = 12;
  options.shots_per_patch = 9000;
  return options;
}

sim::LightRig light_in(const sim::Scene& scene, const sim::LightRigOptions& options = usual()) {
  return *sim::make_light_rig(scene, options);
}

TEST(RobustScenes, PeopleWhoWalkThroughStopsAreNoWalls) {
  sim::Scene scene = *sim::load_scene("room");
  for (int k = 0; k < 8; ++k) {
    sim::Person person = scene.people.front();
    const double angle = 0.785 * k;
    const Vector3d middle = scene.T_scene_table.t + 2.2 * Vector3d(std::cos(angle), std::sin(angle), 0.0);
    const Vector3d way = 0.8 * Vector3d(-std::sin(angle), std::cos(angle), 0.0);
    person.path = {middle - way, middle + way};
    for (Vector3d& foot : person.path) foot.z() = 0.0;
    person.speed_m_s = 0.2 + 0.15 * k;
    scene.people.push_back(person);
  }
  const Calibrated seen = calibrate(light_in(scene));
  seen.expect_all_good();
  seen.expect_right_or_flagged(0.005);
}

TEST(RobustScenes, GlassAndMirrorsShowWhatIsNotThere) {
  const Calibrated seen = calibrate(light_in(*sim::load_scene("glass_room")));
  seen.expect_right_or_flagged(0.01);
}

// A hall without anything in it but a door before its end, hinged at y = 1 and turned open by `angle_deg`.
sim::Scene hall(double width, double height, double angle_deg) {
  std::string objects = walls_of_room(16.0, 10.0, 4.0);
  const double a = to_rad(angle_deg);
  if (width > 0.0) {
    objects += wall(7.9 - 0.5 * width * std::sin(a), 1.0 - 0.5 * width * std::cos(a), width, height, -angle_deg);
  }
  return bare_scene(objects, true, "1.3, -0.8");
}

sim::LightRig opened(const sim::Scene& before, const sim::Scene& after, sim::LightRigOptions options, int from) {
  sim::LightRig light = light_in(before, options);
  for (const Patch& patch : light_in(after, options).patches) {
    if (patch.stop < from) continue;
    for (Patch& old : light.patches) {
      if (old.stop == patch.stop && old.sensor == patch.sensor) old = patch;
    }
  }
  return light;
}

// By little, so that it stays within the gates of the wall behind it, and by much.
TEST(RobustScenes, AGateThatOpensBetweenStopsBendsNothing) {
  for (const double angle_deg : {1.0, 20.0}) {
    SCOPED_TRACE(angle_deg);
    const Calibrated seen = calibrate(opened(hall(4.0, 3.5, 0.0), hall(4.0, 3.5, angle_deg), usual(), 6));
    seen.expect_all_good();
    seen.expect_right_or_flagged(0.005);
  }
}

TEST(RobustScenes, ADoorThatOpensBetweenStopsIsNoFalseAlarm) {
  const Calibrated seen = calibrate(opened(hall(1.0, 2.1, 0.0), hall(1.0, 2.1, 75.0), usual(), 6));
  seen.expect_all_good();
  seen.expect_right_or_flagged(0.005);
}

// A LiDAR of which all points from a stop on are seen from T_base_sensor slip.
sim::LightRig slipped(sim::LightRig light, int sensor, int from, const SE3& slip) {
  for (Patch& patch : light.patches) {
    if (patch.sensor != sensor || patch.stop < from) continue;
    for (Point& point : patch.points) {
      const Eigen::Vector3f p = (slip.inverse() * Vector3d(point.x, point.y, point.z)).cast<float>();
      point.x = p.x();
      point.y = p.y();
      point.z = p.z();
    }
  }
  return light;
}

TEST(RobustScenes, ALidarWhoseMountSlipsBetweenStopsIsNotGood) {
  const SE3 slips[] = {{exp_so3(to_rad(0.5) * Vector3d::UnitZ()), Vector3d::Zero()},
                       {exp_so3(to_rad(3.0) * Vector3d::UnitZ()), Vector3d::Zero()},
                       {Matrix3d::Identity(), Vector3d(0.0, 0.03, 0.0)}};
  for (const char* scene : {"room", "courtyard"}) {
    const sim::LightRig light = light_in(*sim::load_scene(scene));
    for (const SE3& slip : slips) {
      const SensorResult sensor = calibrate(slipped(light, 1, 6, slip)).result.sensors[1];
      EXPECT_NE(sensor.status, Status::good) << scene << slip.t.transpose();
      EXPECT_THAT(sensor.reasons, Contains(testing::AnyOf(HasSubstr("stops before 6 and from it on give"),
                                                          HasSubstr("saw before stop 6"))))
          << scene << slip.t.transpose();
    }
  }
}

// By halves of the stops alone it would not show.
TEST(RobustScenes, ALidarWhoseMountSlipsAndReturnsIsAsSureAsItsStopsAgree) {
  sim::LightRig light = light_in(*sim::load_scene("courtyard"));
  for (Patch& patch : light.patches) {
    if (patch.sensor != 1 || patch.stop < 4 || patch.stop > 6) continue;
    for (Point& point : patch.points) point.y -= 0.02F;
  }
  const Calibrated seen = calibrate(light);
  EXPECT_EQ(seen.result.sensors[1].status, Status::weak);
  EXPECT_THAT(seen.result.sensors[1].reasons, Contains(HasSubstr("single stops differ in it by")));
  // Its neighbours too, as the stops followed it by a part.
  for (std::size_t i = 1; i < seen.result.sensors.size(); ++i) {
    const SensorResult& sensor = seen.result.sensors[i];
    ASSERT_TRUE(sensor.T_base_sensor);
    const Vector3d off = (seen.run.truth.T_base_sensor[i].inverse() * *sensor.T_base_sensor).t;
    const Matrix3d covariance = sensor.covariance.bottomRightCorner<3, 3>();
    EXPECT_LT(off.dot(solve_symmetric3(covariance, off)) / 3.0, 5.0) << sensor.name;  // 42 for one by residuals alone
  }
}

// Half of the stop's points are seen from another pose: no cutting of stops (core/stops) came before this.
TEST(RobustScenes, AStopThatTheRigWasBumpedInDoesNotBendTheRest) {
  for (const double bump_deg : {0.4, 2.0}) {
    sim::LightRigOptions options = usual();
    options.turntable.bumps = {{5, 1.0, to_rad(bump_deg)}};
    SCOPED_TRACE(bump_deg);
    const Calibrated seen = calibrate(light_in(*sim::load_scene("room"), options));
    seen.expect_all_good();
    seen.expect_right_or_flagged(0.005);
  }
}

// Every patch sees each two degrees of a surface 8 mm off (1 sigma), on its own; those of one stop 150 mm.
sim::LightRig uneven(sim::LightRig light, int torn_stop) {
  for (std::size_t k = 0; k < light.patches.size(); ++k) {
    const double sigma_m = light.patches[k].stop == torn_stop ? 0.15 : 0.008;
    for (Point& point : light.patches[k].points) {
      const Vector3d p(point.x, point.y, point.z);
      const auto bin = [](double x, double y) {
        return static_cast<std::uint64_t>(std::atan2(y, x) / to_rad(2.0) + 400.0);
      };
      Random random(k, bin(p.x(), p.y()) * 1000 + bin(std::hypot(p.x(), p.y()), p.z()));
      const Vector3d moved = p * (1.0 + sigma_m * random.normal() / p.norm());
      point.x = static_cast<float>(moved.x());
      point.y = static_cast<float>(moved.y());
      point.z = static_cast<float>(moved.z());
    }
  }
  return light;
}

TEST(RobustScenes, UnevenSurfacesAreNotForgottenWhenAStopIsLeftOut) {
  const sim::LightRig light = light_in(*sim::load_scene("room"));
  const Calibrated whole = calibrate(uneven(light, -1));
  const Calibrated torn = calibrate(uneven(light, 5));
  ASSERT_THAT(torn.warnings, Contains(HasSubstr("stop 5 is left out: little of what was seen from it lies on")));
  for (std::size_t i = 1; i < whole.result.sensors.size(); ++i) {
    const auto sigma_m = [i](const Calibrated& seen) {
      return std::sqrt(seen.result.sensors[i].covariance.diagonal().tail<3>().sum());
    };
    EXPECT_GT(sigma_m(torn), 0.8 * sigma_m(whole)) << whole.result.sensors[i].name;
    EXPECT_LT(torn.error_m(i), 3.0 * sigma_m(torn)) << whole.result.sensors[i].name;
  }
}

}  // namespace
}  // namespace rigcal
