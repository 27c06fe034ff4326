#include "tests/support/make_result.h"

namespace rigcal {

CalibrationResult make_result() {
  CalibrationResult result;
  result.base = "avia";
  result.method = "targetless";
  result.status = Status::failed;
  SensorResult base;
  base.name = "avia";
  base.status = Status::good;
  base.T_base_sensor = SE3{};
  SensorResult weak;
  weak.name = "mid40_left";
  weak.status = Status::weak;
  weak.reasons = {"height is not fixed: no \"floor\" was seen", "one stop only"};
  Vector6d xi;
  xi << 0.1, -0.2, 1.0 / 3.0, 0.1, -1e-7, 2.0 / 3.0;
  weak.T_base_sensor = SE3::exp(xi);
  Vector6d sigma;
  sigma << 1e-5, 2e-5, 3e-5, 1e-3, 2e-3, 3e-3;
  weak.covariance = sigma.cwiseProduct(sigma).asDiagonal();
  SensorResult failed;
  failed.name = "mid40_right";
  failed.reasons = {"no stop connects it with the base"};
  result.sensors = {base, weak, failed};
  StopPose first;
  first.stop = {0, 1'700'000'000'000'000'000, 1'700'000'002'000'000'001};
  StopPose unknown;
  unknown.stop = {1, 1'700'000'003'000'000'000, 1'700'000'005'000'000'000};
  unknown.known = false;
  StopPose last;
  last.stop = {2, 1'700'000'006'000'000'000, 1'700'000'008'000'000'000};
  last.T_G_base = *weak.T_base_sensor;
  result.trajectory = {first, unknown, last};
  StageReport stage;
  stage.name = "joint";
  stage.wall_s = 0.25;
  stage.iterations = 7;
  stage.cost_before = 12.0;
  stage.cost_after = 3.0;
  stage.counts = {{"planes", 9000.0}};
  stage.peak_memory_mb = 120.5;
  result.stages = {stage};
  result.warnings = {"a packet is damaged"};
  result.map = {{1.0F, 2.0F, 3.0F, 200, 0}, {-1.0F, 0.5F, 0.25F, 7, 1}};
  return result;
}

}  // namespace rigcal
