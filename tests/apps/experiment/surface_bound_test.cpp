// The bound against the whole problem written down, with a direction of its own for each shot and nothing eliminated.
#include "apps/experiment/bound/surface_bound.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "apps/experiment/bound/bound_experiment.h"
#include "apps/experiment/bound/light_rig_bound.h"
#include "core/geometry/numeric_derivative.h"
#include "simdata/rig/random_rig.h"
#include "simdata/scene/scene_file.h"
#include "tests/support/json.h"
#include "tests/support/schema_check.h"

namespace rigcal::bound {
namespace {

struct Plane {
  Vector3d normal;
  Vector3d point;
};

// A LiDAR and another one before three planes, at three stops.
struct TinyRig {
  std::vector<SE3> T_base_sensor{SE3{}, {exp_so3({0.1, -0.3, 0.7}), {0.2, -0.1, 0.3}}};
  std::vector<SE3> T_G_base{
      SE3{}, {exp_so3({0.02, 0.01, 0.5}), {0.1, 0.2, 0.0}}, {exp_so3({-0.1, 0.05, -0.4}), {-0.2, 0.1, 0.1}}};
  std::vector<Plane> planes{{Vector3d(1.0, 0.1, -0.1).normalized(), {4.0, 0.0, 0.0}},
                            {Vector3d(0.2, 1.0, 0.05).normalized(), {0.0, 5.0, 0.0}},
                            {Vector3d(-0.1, 0.2, 1.0).normalized(), {0.0, 0.0, -3.0}}};
  double range_sigma = 0.02;
  double angle_sigma = 0.001;
  int shots = 4;  // Of each patch on each plane.
};

// Where shot k of a patch on a plane is: places spread over two square metres and more.
Vector3d place_on(const Plane& plane, int k, int patch) {
  const Vector3d along = plane.normal.unitOrthogonal();
  const Vector3d across = plane.normal.cross(along);
  return plane.point + std::cos(2.1 * k + patch) * (1.0 + 0.3 * k) * along + std::sin(1.7 * k + 2.0 * patch) * across;
}

template <class F>
void for_each_shot(const TinyRig& rig, const F& f) {
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 2; ++i) {
      for (int plane = 0; plane < 3; ++plane) {
        for (int k = 0; k < rig.shots; ++k) {
          const SE3 T = rig.T_G_base[static_cast<std::size_t>(j)] * rig.T_base_sensor[static_cast<std::size_t>(i)];
          f(i, j, plane, T.inverse() * place_on(rig.planes[static_cast<std::size_t>(plane)], k, 2 * j + i));
        }
      }
    }
  }
}

Matrix6d bound_of(const TinyRig& rig) {
  SurfaceBound bound(rig.T_base_sensor, rig.T_G_base, 0);
  for (const Plane& plane : rig.planes) bound.add_plane(plane.normal, plane.point);
  for_each_shot(rig, [&](int i, int j, int plane, const Vector3d& p) {
    const SE3 T = rig.T_G_base[static_cast<std::size_t>(j)] * rig.T_base_sensor[static_cast<std::size_t>(i)];
    SurfaceShot shot;
    shot.point = p;
    shot.normal = T.R.transpose() * rig.planes[static_cast<std::size_t>(plane)].normal;
    shot.range_variance = rig.range_sigma * rig.range_sigma;
    shot.angle_variance = rig.angle_sigma * rig.angle_sigma;
    ShotSums sums = ShotSums::Zero();
    add_shot(T, shot, sums);
    bound.add(i, j, plane, sums);
  });
  EXPECT_TRUE(bound.covariances()[0]->isZero()) << "the base";
  return bound.covariances()[1].value_or(Matrix6d::Zero());
}

// The inverse of the Fisher matrix of extrinsic, poses, planes and the two angles of each shot's true direction, from
// what is measured: a range and two angles a shot.
Matrix6d bound_of_the_whole(const TinyRig& rig) {
  std::vector<Vector3d> directions;
  for_each_shot(rig, [&](int, int, int, const Vector3d& p) { directions.push_back(p.normalized()); });
  const auto count = static_cast<Eigen::Index>(directions.size());
  const Eigen::Index first_angle = 6 + 12 + 9;
  const auto measured = [&](const Eigen::VectorXd& x) {
    TinyRig moved = rig;
    moved.T_base_sensor[1] = rig.T_base_sensor[1] * SE3::exp(x.segment<6>(0));
    for (int j = 1; j < 3; ++j) {
      const auto at = static_cast<std::size_t>(j);
      moved.T_G_base[at] = rig.T_G_base[at] * SE3::exp(x.segment<6>(6 * j));
    }
    for (int k = 0; k < 3; ++k) {
      Plane& plane = moved.planes[static_cast<std::size_t>(k)];
      const Vector3d along = plane.normal.unitOrthogonal();
      const Vector3d turn = x[18 + 3 * k] * along + x[19 + 3 * k] * plane.normal.cross(along);
      plane.point += x[20 + 3 * k] * plane.normal;
      plane.normal = exp_so3(turn) * plane.normal;
    }
    Eigen::VectorXd out(3 * count);
    Eigen::Index shot = 0;
    for_each_shot(rig, [&](int i, int j, int plane, const Vector3d&) {
      const SE3 T = moved.T_G_base[static_cast<std::size_t>(j)] * moved.T_base_sensor[static_cast<std::size_t>(i)];
      const Vector3d& straight = directions[static_cast<std::size_t>(shot)];
      const Vector3d left = straight.unitOrthogonal();
      const double a = x[first_angle + 2 * shot];
      const double b = x[first_angle + 2 * shot + 1];
      const Vector3d ray = T.R * (straight + a * left + b * straight.cross(left)).normalized();
      const Plane& on = moved.planes[static_cast<std::size_t>(plane)];
      out[3 * shot] = on.normal.dot(on.point - T.t) / on.normal.dot(ray) / rig.range_sigma;
      out[3 * shot + 1] = a / rig.angle_sigma;
      out[3 * shot + 2] = b / rig.angle_sigma;
      ++shot;
    });
    return out;
  };
  const Eigen::MatrixXd J = numeric_jacobian(measured, static_cast<int>(first_angle + 2 * count));
  const Eigen::MatrixXd information = J.transpose() * J;
  return information.ldlt().solve(Eigen::MatrixXd::Identity(information.rows(), 6)).topRows<6>();
}

TEST(SurfaceBound, IsThatOfTheWholeProblemWithADirectionForEachShot) {
  const TinyRig rig;
  const Matrix6d bound = bound_of(rig);
  const Matrix6d whole = bound_of_the_whole(rig);
  const Vector6d scale = whole.diagonal().cwiseSqrt().cwiseInverse();
  EXPECT_LT((scale.asDiagonal() * (bound - whole) * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-5) << bound << "\n\n"
                                                                                                     << whole;
  EXPECT_GT(std::sqrt(bound(5, 5)), 0.003) << "millimetres, not rounding";
}

TEST(SurfaceBound, KnowsWhatShotsDoNotTell) {
  TinyRig rig;
  rig.planes[1] = {rig.planes[0].normal, rig.planes[0].point + Vector3d(1.0, 0.0, 0.0)};
  rig.planes[2] = {rig.planes[0].normal, rig.planes[0].point + Vector3d(2.0, 0.0, 0.0)};
  SurfaceBound bound(rig.T_base_sensor, rig.T_G_base, 0);
  for (const Plane& plane : rig.planes) bound.add_plane(plane.normal, plane.point);
  EXPECT_FALSE(bound.covariances()[1]) << "no shot at all";
  EXPECT_TRUE(bound_of(rig).isZero()) << "along parallel walls nothing is known";
}

TEST(BoundOfLightRig, FallsWithTheShotsAndRisesWhereSurfacesAreInPieces) {
  const auto scene = sim::load_scene("room");
  ASSERT_TRUE(scene) << scene.error().message();
  sim::LightRigOptions options;
  options.turntable.stops = 8;
  options.unit_errors.footprint_share = 0.0;
  const auto trace = [&](int points, double noise, const SurfaceTrust& trust) {
    options.shots_per_patch = points;
    auto light = sim::make_light_rig(*scene, options);
    EXPECT_TRUE(light);
    for (sim::SimulatedLidar& lidar : light->lidars) {
      lidar.noise.range_sigma *= noise;
      lidar.noise.range_sigma_per_m *= noise;
      lidar.noise.range_sigma_max *= noise;
      lidar.noise.angle_sigma_rad *= noise;
    }
    return bound_of_light_rig(*scene, *light, trust)[1].value_or(Matrix6d::Zero()).diagonal().tail<3>().sum();
  };
  const double whole = trace(4000, 1.0, {});
  EXPECT_GT(1e3 * std::sqrt(whole), 0.2);
  EXPECT_LT(1e3 * std::sqrt(whole), 3.0);
  EXPECT_NEAR(trace(16000, 1.0, {}) / whole, 0.25, 0.03);
  EXPECT_NEAR(trace(4000, 1.3, {}) / whole, 1.69, 0.02) << "but for the millimetres of the wire";
  EXPECT_GT(trace(4000, 1.0, {2.0}), whole);
  EXPECT_GT(trace(4000, 1.0, {0.5}), 1.1 * trace(4000, 1.0, {2.0}));
}

// With a wrong place in the scene, shots would stand off the surfaces behind them and be left out.
TEST(BoundOfLightRig, KnowsWhereARandomRigStands) {
  const auto scene = sim::load_scene("room");
  ASSERT_TRUE(scene) << scene.error().message();
  sim::LightRigOptions options;
  options.turntable.stops = 8;
  options.shots_per_patch = 4000;
  sim::RandomMounting mounting;
  mounting.shares_surfaces = true;
  const auto light = sim::make_random_rig(*scene, options, mounting);
  ASSERT_TRUE(light) << light.error().message();
  const auto bounds = bound_of_light_rig(*scene, *light);
  ASSERT_EQ(bounds.size(), 4U);
  for (std::size_t i = 1; i < bounds.size(); ++i) {
    ASSERT_TRUE(bounds[i]) << i;
    EXPECT_GT(std::sqrt(bounds[i]->diagonal().tail<3>().sum()), 1e-4) << i;
    EXPECT_LT(std::sqrt(bounds[i]->diagonal().tail<3>().sum()), 5e-3) << i;
  }
}

TEST(BoundFigures, AreRootMeanSquaresOverEachLidarsOwnBound) {
  BoundExperiment experiment;
  BoundTrial trial;
  trial.scene = "room";
  trial.error_m2 = 4e-6;
  trial.bound_m2 = 1e-6;
  trial.error_rad2 = trial.bound_rad2 = trial.pieces_rad2 = 1e-8;
  trial.pieces_m2 = 2e-6;
  trial.sigma_m2 = 9e-6;
  trial.sigma_rad2 = 4e-8;
  trial.whitened = 24.0;
  experiment.trials = {trial, trial};
  experiment.trials[1].error_m2 = 0.0;
  experiment.trials[1].scene = "field";
  const BoundFigures all = bound_figures(experiment, "");
  EXPECT_EQ(all.lidars, 2);
  EXPECT_NEAR(all.ratio_m, std::sqrt(2.0), 1e-9);
  const BoundFigures room = bound_figures(experiment, "room");
  EXPECT_NEAR(room.ratio_m, 2.0, 1e-9);
  EXPECT_NEAR(room.ratio_rad, 1.0, 1e-9);
  EXPECT_NEAR(room.ratio, 2.0, 1e-9);
  EXPECT_NEAR(room.pieces_ratio_m, std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(room.sigma_ratio_m, 3.0, 1e-9);
  EXPECT_NEAR(room.sigma_ratio_rad, 2.0, 1e-9);
  EXPECT_NEAR(room.error_mm, 2.0, 1e-9);
}

TEST(TryBounds, NoLidarIsFarFromTheBoundNorBelowIt) {
  BoundExperimentOptions options;
  options.rigs = 3;
  options.points = 8000;
  SilentReporter silent;
  const auto experiment = try_bounds(options, {silent});
  ASSERT_TRUE(experiment) << experiment.error().message();
  EXPECT_GE(experiment->trials.size(), 6U);
  const BoundFigures all = bound_figures(*experiment, "");
  EXPECT_GT(all.ratio_m, 0.6) << bound_experiment_text(*experiment);
  EXPECT_LT(all.ratio_m, 8.0) << bound_experiment_text(*experiment);
  const auto json = parse_json(bound_experiment_json(*experiment));
  EXPECT_TRUE(fits_schema("experiment_bound.json", json));
  EXPECT_EQ(json["trials"].size(), experiment->trials.size());
}

TEST(TryBounds, EndWhenTold) {
  SilentReporter silent;
  std::stop_source stop;
  stop.request_stop();
  const auto experiment = try_bounds({}, {silent, stop.get_token()});
  ASSERT_FALSE(experiment);
  EXPECT_EQ(experiment.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace rigcal::bound
