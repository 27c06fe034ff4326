#include "core/board/board_adjustment.h"

#include <gtest/gtest.h>

#include "core/board/board_costs.h"
#include "core/board/board_halves.h"
#include "core/geometry/matrix6.h"
#include "core/geometry/numeric_derivative.h"
#include "tests/support/make_planes.h"

namespace rigcal {
namespace {

const BoardModel& test_board() {
  static const BoardModel board({"checkerboard", {7, 5}, 0.095, {0.85, 0.61}, {0.0, 0.0}});
  return board;
}

CameraIntrinsics test_camera() {
  return {DistortionModel::radtan, 1280, 720, 640.0, 640.0, 639.5, 359.5, {-0.1, 0.02, 1e-3, -1e-3, 0.0}};
}

struct World {
  SE3 T_lidar_camera;
  std::vector<SE3> T_lidar_board;
  std::vector<BoardSighting> sightings;
};

BoardSighting see_by_camera(int stop, const SE3& T_camera_board, double sigma_px, Random& random) {
  const CameraModel camera(test_camera());
  ImageBoard seen;
  for (int id = 0; id < test_board().corner_count(); ++id) {
    const auto pixel = camera.project(T_camera_board * test_board().corner(id));
    EXPECT_TRUE(pixel);
    seen.ids.push_back(id);
    seen.pixels.push_back(*pixel + sigma_px * Eigen::Vector2d(random.normal(), random.normal()));
  }
  // Which end is up the image cannot tell.
  if (random.uniform() < 0.5) std::reverse(seen.pixels.begin(), seen.pixels.end());
  seen.alternatives = test_board().pattern_turns();
  const auto pose = find_image_pose(seen, test_board(), camera);
  EXPECT_TRUE(pose);
  return image_sighting(1, stop, seen, *pose, test_board(), camera);
}

BoardSighting see_by_lidar(int stop, const SE3& T_lidar_board, double sigma_m, double range_offset_m, Random& random) {
  CloudBoard seen;
  const Eigen::Vector2d half = 0.5 * test_board().size();
  const auto measured = [&](const Vector3d& on_board, double sigma) {
    const Vector3d p = T_lidar_board * on_board;
    return Vector3d(p + (sigma * random.normal() - range_offset_m) * p.normalized());
  };
  for (int k = 0; k < 300; ++k) {
    const Vector3d p(half.x() * random.uniform(-1.0, 1.0), half.y() * random.uniform(-1.0, 1.0), 0.0);
    seen.points.push_back(measured(p, sigma_m));
  }
  for (int k = 0; k < 24; ++k) {
    BorderPoint b;
    b.axis = k % 2;
    b.sign = k % 4 < 2 ? 1 : -1;
    Vector3d p = Vector3d::Zero();
    p[b.axis] = b.sign * half[b.axis] + 0.004 * random.normal();
    p[1 - b.axis] = half[1 - b.axis] * random.uniform(-1.0, 1.0);
    b.p = measured(p, 0.0);
    seen.border.push_back(b);
  }
  seen.border_rms_m = 0.004;
  seen.plane_rms_m = sigma_m;
  // As the fit of one plate leaves it: nearly right, but for half a turn.
  seen.T_lidar_board = T_lidar_board * random_pose(random, to_rad(0.5), 0.003);
  BoardSighting out = cloud_sighting(0, stop, seen, test_board());
  return random.uniform() < 0.5 ? resolved(out, 0, test_board()) : out;
}

World make_world(int stops, double range_offset_m, Random& random) {
  World out;
  SE3 T_camera_lidar;
  T_camera_lidar.R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  T_camera_lidar.t = {0.1, -0.05, 0.08};
  T_camera_lidar = T_camera_lidar * random_pose(random, 0.05, 0.02);
  out.T_lidar_camera = T_camera_lidar.inverse();
  for (int stop = 0; stop < stops; ++stop) {
    SE3 T_camera_board;
    T_camera_board.R = exp_so3({random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), random.uniform(-1.0, 1.0)});
    const double z = random.uniform(1.8, 3.2);
    T_camera_board.t = {z * random.uniform(-0.4, 0.4), z * random.uniform(-0.2, 0.2), z};
    out.T_lidar_board.push_back(out.T_lidar_camera * T_camera_board);
    out.sightings.push_back(see_by_camera(stop, T_camera_board, 0.1, random));
    out.sightings.push_back(see_by_lidar(stop, out.T_lidar_board.back(), 0.012, range_offset_m, random));
    // Turns unknown of both.
    out.sightings.back().alternatives = test_board().plate_turns();
  }
  return out;
}

std::vector<BoardSensor> make_sensors(const SE3& T_lidar_camera) {
  std::vector<BoardSensor> sensors(2);
  sensors[0].name = "lidar";
  sensors[0].fixed = true;
  sensors[1].name = "camera";
  sensors[1].T_base_sensor = T_lidar_camera;
  sensors[1].camera = test_camera();
  return sensors;
}

BoardAdjustment calibrate(const std::vector<BoardSighting>& sightings, const BoardAdjustOptions& options = {}) {
  const auto placed = place_pair(sightings, 0, 1, test_board(), std::nullopt);
  EXPECT_TRUE(placed);
  const auto sensors = make_sensors(placed->T_a_b);
  return adjust_boards(sensors, board_places(sightings, sensors, test_board()), test_board(), options);
}

TEST(BoardCosts, HaveTheDerivativesOfACornerThatDifferencesGive) {
  Random random(3);
  const board::ChangingCamera camera(test_camera());
  const SE3 T_base_camera = random_pose(random, 0.3, 0.3);
  const SE3 T_camera_board{exp_so3({0.3, -0.2, 0.4}), {0.2, -0.1, 1.7}};
  const SE3 T_base_board = T_base_camera * T_camera_board;
  const board::CornerCost cost{&T_base_camera, &T_base_board, &camera, test_board().corner(9), {600.0, 300.0}, 0.5};
  // Near zero, where a solver begins, and away from it.
  for (const double size : {1e-9, 0.1}) {
    Eigen::VectorXd at(12 + intrinsics_count);
    for (int k = 0; k < 12; ++k) at[k] = size * random.normal();
    const auto intrinsics = board::ChangingCamera::values_of(test_camera());
    for (int k = 0; k < intrinsics_count; ++k) at[12 + k] = intrinsics[static_cast<std::size_t>(k)];
    const auto f = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      const Eigen::VectorXd moved = at + x;
      const double* blocks[] = {moved.data(), moved.data() + 6, moved.data() + 12};
      Eigen::VectorXd residuals(2);
      EXPECT_TRUE(cost.evaluate(blocks, residuals.data(), nullptr));
      return residuals;
    };
    const Eigen::MatrixXd expected = numeric_jacobian(f, 12 + intrinsics_count);
    Eigen::Matrix<double, 2, 6, Eigen::RowMajor> by_camera;
    Eigen::Matrix<double, 2, 6, Eigen::RowMajor> by_board;
    Eigen::Matrix<double, 2, intrinsics_count, Eigen::RowMajor> by_intrinsics;
    double* jacobians[] = {by_camera.data(), by_board.data(), by_intrinsics.data()};
    const double* blocks[] = {at.data(), at.data() + 6, at.data() + 12};
    double residuals[2];
    ASSERT_TRUE(cost.evaluate(blocks, residuals, jacobians));
    EXPECT_LT((expected.leftCols<6>() - by_camera).norm(), 1e-4 * by_camera.norm());
    EXPECT_LT((expected.middleCols<6>(6) - by_board).norm(), 1e-4 * by_board.norm());
    EXPECT_LT((expected.rightCols<intrinsics_count>() - by_intrinsics).norm(), 1e-4 * by_intrinsics.norm());
  }
}

TEST(BoardCosts, SumAnyNumberOfPointsInSevenResiduals) {
  Random random(4);
  const SE3 T_base_lidar = random_pose(random, 1.0, 1.0);
  const SE3 T_base_board = random_pose(random, 1.0, 2.0);
  std::vector<Vector3d> points;
  for (int k = 0; k < 50; ++k) points.emplace_back(random.normal(), random.normal(), 2.0 + random.normal());
  const auto moments = board::plane_moments(points);
  const board::PlaneCost cost{&T_base_lidar, &T_base_board, &moments, 0.5};
  double lidar_x[6];
  double board_x[6];
  for (int k = 0; k < 6; ++k) {
    lidar_x[k] = 0.1 * random.normal();
    board_x[k] = 0.1 * random.normal();
  }
  const double offset = 0.07;
  double residuals[7];
  ASSERT_TRUE(cost(lidar_x, board_x, &offset, residuals));
  double sum = 0.0;
  for (const double r : residuals) sum += r * r;
  const SE3 T = board::pose_at(T_base_board, board_x).inverse() * board::pose_at(T_base_lidar, lidar_x);
  double direct = 0.0;
  for (const Vector3d& p : points) direct += std::pow((T * (p + offset * p.normalized())).z() / 0.5, 2);
  EXPECT_NEAR(sum, direct, 1e-9 * direct);
}

TEST(BoardCosts, SeeSquaresAsDirectionsAndTheirSizeAsADistance) {
  Random random(7);
  const SE3 T_base_lidar = random_pose(random, 0.3, 0.3);
  const SE3 T_lidar_board{exp_so3({0.5, -0.3, 0.4}), {0.2, -0.1, 3.0}};
  const SE3 T_base_board = T_base_lidar * T_lidar_board;
  const auto residual_of = [&](const SE3& T_lidar_pattern) {
    const board::SquaresCost cost{&T_base_lidar, &T_base_board, T_lidar_pattern, 0.002, 0.01, 0.005};
    const double still[6] = {};
    Eigen::Vector4d residual;
    EXPECT_TRUE(cost(still, still, residual.data()));
    return residual;
  };
  EXPECT_LT(residual_of(T_lidar_board).norm(), 1e-9);
  SE3 farther = T_lidar_board;
  farther.t *= 1.01;
  // Farther along the ray: nothing moves on the plane, squares are a hundredth too small.
  EXPECT_LT((residual_of(farther) - Eigen::Vector4d(0.0, 0.0, 0.0, 2.0)).norm(), 1e-9);
  const SE3 shifted = T_lidar_board * SE3{Matrix3d::Identity(), {0.004, -0.002, 0.0}};
  EXPECT_LT((residual_of(shifted) - Eigen::Vector4d(-2.0, 1.0, 0.0, 0.0)).norm(), 1e-9);
  const SE3 turned = T_lidar_board * SE3{exp_so3({0.0, 0.0, 0.01}), Vector3d::Zero()};
  EXPECT_NEAR(residual_of(turned)[2], -1.0, 1e-3);
}

TEST(BoardAdjustment, FindsTheCameraAndKnowsHowWell) {
  double nees = 0.0;
  constexpr int trials = 12;
  for (int trial = 0; trial < trials; ++trial) {
    Random random(100 + static_cast<std::uint64_t>(trial));
    const World world = make_world(10, 0.0, random);
    BoardAdjustOptions options;
    options.plane_floor_m = 0.0;
    options.border_floor_m = 0.0;
    const BoardAdjustment found = calibrate(world.sightings, options);
    EXPECT_TRUE(found.converged && found.observable[1]);
    const SE3& T = found.sensors[1].T_base_sensor;
    EXPECT_LT(to_deg(rotation_distance(T.R, world.T_lidar_camera.R)), 0.15);
    EXPECT_LT((T.t - world.T_lidar_camera.t).norm(), 0.012);
    EXPECT_NEAR(found.sensors[1].sigma_px, 0.1, 0.02);
    EXPECT_NEAR(found.sensors[0].sigma_plane_m, 0.011, 0.002);  // along slanting rays
    const Vector6d xi = (T.inverse() * world.T_lidar_camera).log();
    nees += xi.dot(solve_symmetric6(found.covariances[1], xi)) / 6.0 / trials;
  }
  EXPECT_GT(nees, 0.4);
  EXPECT_LT(nees, 2.0);
}

// Nine intrinsics and a place from one view are open: for that camera, and for no other sensor.
TEST(BoardAdjustment, KnowsTheOthersAsWellWhereOneCameraIsOpen) {
  Random random(7);
  World world = make_world(10, 0.0, random);
  BoardAdjustOptions options;
  options.refine_intrinsics = true;
  const BoardAdjustment alone = calibrate(world.sightings, options);
  const auto placed = place_pair(world.sightings, 0, 1, test_board(), std::nullopt);
  ASSERT_TRUE(placed);
  std::vector<BoardSensor> sensors = make_sensors(placed->T_a_b);
  sensors.push_back(sensors[1]);
  sensors.push_back(sensors[1]);
  sensors[2].name = "saw it once";
  sensors[3].name = "saw nothing";
  sensors[2].T_base_sensor = world.T_lidar_camera * SE3{exp_so3({0.0, 0.1, 0.0}), {0.1, 0.0, 0.0}};
  const SE3 T_camera_board = sensors[2].T_base_sensor.inverse() * world.T_lidar_board[0];
  world.sightings.push_back(see_by_camera(0, T_camera_board, 0.1, random));
  world.sightings.back().sensor = 2;
  const auto places = board_places(world.sightings, sensors, test_board());
  const BoardAdjustment found = adjust_boards(sensors, places, test_board(), options);
  EXPECT_TRUE(alone.converged);
  EXPECT_TRUE(found.converged);
  EXPECT_EQ(alone.observable, (std::vector<char>{1, 1}));
  EXPECT_EQ(found.observable, (std::vector<char>{1, 1, 1, 0}));
  // Nothing but what is usual of lenses holds it.
  EXPECT_GT(found.covariances[2](5, 5), 0.2 * 0.2);
  for (int k = 0; k < 6; ++k) {
    const double usual = std::sqrt(alone.covariances[1](k, k));
    EXPECT_NEAR(std::sqrt(found.covariances[1](k, k)), usual, 0.05 * usual);
  }
  EXPECT_NEAR(found.range_offset_sigma_m[0], alone.range_offset_sigma_m[0], 0.05 * alone.range_offset_sigma_m[0]);
}

// The pose that was found is none of the places: by the first of them the board stands where others see it, too.
TEST(BoardPlaces, OfAPartAreWhereItsFirstPlaceIs) {
  const SE3 T_camera_board{exp_so3({0.1, -0.2, 0.3}), {0.1, 0.0, 1.5}};
  const SE3 half_turn = test_board().pattern_turns()[1];
  std::vector<BoardSensor> sensors = make_sensors(SE3{});
  sensors.push_back(sensors[1]);
  std::vector<BoardSighting> sightings;
  for (int sensor = 1; sensor < 3; ++sensor) {
    ImageBoard part;
    part.whole = false;
    const CameraModel camera(test_camera());
    for (int id = 0; id < test_board().corner_count() / 2; ++id) {
      part.ids.push_back(test_board().id_at(half_turn * test_board().corner(id)));
      part.pixels.push_back(*camera.project(T_camera_board * test_board().corner(id)));
    }
    part.alternatives = {half_turn};
    const ImagePose pose{T_camera_board * half_turn.inverse(), 0.1};
    sightings.push_back(image_sighting(sensor, 0, part, pose, test_board(), camera));
  }
  const auto places = board_places(sightings, sensors, test_board());
  ASSERT_EQ(places.size(), 1U);
  EXPECT_LT(test_board().corner_distance(places[0].T_base_board, T_camera_board), 1e-9);
  ASSERT_EQ(places[0].sightings.size(), 2U);
  EXPECT_EQ(places[0].sightings[0].image->ids[0], 0);
}

TEST(BoardAdjustment, NoticesRangesThatAreTooShort) {
  Random random(5);
  const World world = make_world(12, 0.03, random);
  const BoardAdjustment found = calibrate(world.sightings);
  EXPECT_NEAR(found.sensors[0].range_offset_m, 0.03, 0.008);
  EXPECT_LT(found.range_offset_sigma_m[0], 0.008);
  EXPECT_LT((found.sensors[1].T_base_sensor.t - world.T_lidar_camera.t).norm(), 0.012);
  BoardAdjustOptions believed;
  believed.range_offset_sigma_m = 0.0;
  EXPECT_EQ(calibrate(world.sightings, believed).sensors[0].range_offset_m, 0.0);
}

TEST(BoardAdjustment, KnowsRangesNoBetterThanTheBoardsAgreeOnThem) {
  double squares = 0.0;
  double sigmas = 0.0;
  constexpr int trials = 12;
  for (int trial = 0; trial < trials; ++trial) {
    Random random(200 + static_cast<std::uint64_t>(trial));
    World world = make_world(10, 0.02, random);
    // Each plate as a whole is seen nearer or farther, which its own residuals do not show.
    for (BoardSighting& s : world.sightings) {
      if (!s.cloud) continue;
      const double by = 0.01 * random.normal();
      for (Vector3d& p : s.cloud->points) p += by * p.normalized();
      for (BorderPoint& b : s.cloud->border) b.p += by * b.p.normalized();
    }
    BoardAdjustOptions options;
    options.drop_outliers = false;
    const BoardAdjustment found = calibrate(world.sightings, options);
    squares += std::pow((found.sensors[0].range_offset_m - 0.02) / found.range_offset_sigma_m[0], 2) / trials;
    sigmas += found.range_offset_sigma_m[0] / trials;
  }
  EXPECT_GT(squares, 0.25);
  EXPECT_LT(squares, 3.0);
  EXPECT_LT(sigmas, 0.015);
}

TEST(BoardAdjustment, KnowsACameraNoBetterThanTheBoardsAgreeOnIt) {
  double nees = 0.0;
  double sigmas_m = 0.0;
  constexpr int trials = 12;
  for (int trial = 0; trial < trials; ++trial) {
    Random random(300 + static_cast<std::uint64_t>(trial));
    World world = make_world(10, 0.0, random);
    // Each plate as a whole is seen to the side and turned, which its own residuals do not show.
    for (BoardSighting& s : world.sightings) {
      if (!s.cloud) continue;
      const Vector3d about = s.T_sensor_board.t;
      const Matrix3d R = exp_so3(0.02 * Vector3d(random.normal(), random.normal(), random.normal()));
      const Vector3d by = 0.01 * Vector3d(random.normal(), random.normal(), random.normal());
      for (Vector3d& p : s.cloud->points) p = R * (p - about) + about + by;
      for (BorderPoint& b : s.cloud->border) b.p = R * (b.p - about) + about + by;
    }
    BoardAdjustOptions options;
    options.drop_outliers = false;
    const BoardAdjustment found = calibrate(world.sightings, options);
    const Vector6d xi = (found.sensors[1].T_base_sensor.inverse() * world.T_lidar_camera).log();
    nees += xi.dot(solve_symmetric6(found.covariances[1], xi)) / 6.0 / trials;
    sigmas_m += std::sqrt(found.covariances[1].bottomRightCorner<3, 3>().trace()) / trials;
  }
  EXPECT_GT(nees, 0.4);
  EXPECT_LT(nees, 2.0);
  EXPECT_LT(sigmas_m, 0.05);
  RecordProperty("nees", std::to_string(nees));
  RecordProperty("sigma_m", std::to_string(sigmas_m));
}

TEST(BoardAdjustment, ThrowsOutABoardThatMoved) {
  Random random(6);
  World world = make_world(10, 0.0, random);
  // Between the image and the scan of stop 3 somebody pushed it by 5 cm.
  for (BoardSighting& s : world.sightings) {
    if (s.stop != 3 || s.sensor != 0) continue;
    s.T_sensor_board.t += Vector3d(0.05, 0.0, 0.0);
    for (Vector3d& p : s.cloud->points) p += Vector3d(0.05, 0.0, 0.0);
    for (BorderPoint& b : s.cloud->border) b.p += Vector3d(0.05, 0.0, 0.0);
  }
  const BoardAdjustment found = calibrate(world.sightings);
  int out = 0;
  for (const BoardPlace& place : found.places) {
    const bool held = place.why_out.empty() && place.sightings.size() > 1;
    out += held ? 0 : 1;
    EXPECT_FALSE(place.stop == 3 && held);
  }
  EXPECT_LE(out, 2);  // that stop, perhaps as two boards
  EXPECT_LT((found.sensors[1].T_base_sensor.t - world.T_lidar_camera.t).norm(), 0.012);
}

TEST(BoardAdjustment, TellsAFocalLengthThatIsOff) {
  Random random(13);
  const World world = make_world(12, 0.0, random);
  for (const double share : {1.0, 1.02}) {
    std::vector<BoardSensor> sensors = make_sensors(world.T_lidar_camera);
    sensors[1].camera->fx *= share;
    sensors[1].camera->fy *= share;
    BoardAdjustOptions options;
    options.free_focal_lengths = true;
    const auto found =
        adjust_boards(sensors, board_places(world.sightings, sensors, test_board()), test_board(), options);
    EXPECT_TRUE(found.converged);
    EXPECT_GT(found.focal_sigma[1], 0.0);
    EXPECT_LT(found.focal_sigma[1], 0.005);
    EXPECT_NEAR(found.sensors[1].camera->fx, 640.0, 4.0 * 640.0 * found.focal_sigma[1]);
    EXPECT_EQ(found.sensors[1].camera->cx, test_camera().cx);
    options.free_focal_lengths = false;
    EXPECT_EQ(adjust_boards(sensors, found.places, test_board(), options).sensors[1].camera->fx, 640.0 * share);
  }
}

TEST(BoardHalves, TellAMountThatSlippedByLessThanBoardsAreToldApartBy) {
  for (const double slip_m : {0.0, 0.03}) {
    Random random(12);
    World world = make_world(12, 0.0, random);
    for (BoardSighting& s : world.sightings) {
      if (s.stop < 6 || s.sensor != 0) continue;
      const Vector3d by(0.0, slip_m, 0.0);
      s.T_sensor_board.t += by;
      s.cloud->T_lidar_board.t += by;
      for (Vector3d& p : s.cloud->points) p += by;
      for (BorderPoint& b : s.cloud->border) b.p += by;
    }
    const BoardAdjustment found = calibrate(world.sightings);
    const auto halves = compare_board_halves(found, test_board(), {});
    ASSERT_EQ(halves.size(), 2u);
    EXPECT_FALSE(halves[0].compared);
    ASSERT_TRUE(halves[1].compared);
    EXPECT_EQ(halves[1].first_later_stop, 6);
    if (slip_m > 0.0) {
      EXPECT_GT(halves[1].chi2, 22.5);
      EXPECT_NEAR(halves[1].translation_m, slip_m, 0.01);
    } else {
      EXPECT_LT(halves[1].chi2, 22.5);
      EXPECT_LT(halves[1].translation_m, 0.012);
    }
  }
}

TEST(BoardPlaces, KeepTheSameBoardTogetherWhicheverWayItWasTurned) {
  Random random(8);
  const World world = make_world(6, 0.0, random);
  const auto sensors = make_sensors(world.T_lidar_camera);
  const auto places = board_places(world.sightings, sensors, test_board());
  ASSERT_EQ(places.size(), 6u);
  for (const BoardPlace& place : places) {
    ASSERT_EQ(place.sightings.size(), 2u);
    const SE3 a = place.sightings[0].T_sensor_board;
    const SE3 b = place.sightings[1].T_sensor_board;
    const int first = place.sightings[0].sensor;
    const SE3 T = first == 0 ? world.T_lidar_camera : world.T_lidar_camera.inverse();
    EXPECT_LT(test_board().corner_distance(a, T * b), 0.05);
  }
}

TEST(PlacePair, FindsNothingWhereNoStopHasBoth) {
  Random random(9);
  World world = make_world(2, 0.0, random);
  std::erase_if(world.sightings, [](const BoardSighting& s) { return s.stop == s.sensor; });
  EXPECT_FALSE(place_pair(world.sightings, 0, 1, test_board(), std::nullopt));
}

TEST(PlacePair, CannotTellHalfATurnByOneBoardButByAGuess) {
  Random random(10);
  const World world = make_world(1, 0.0, random);
  const auto blind = place_pair(world.sightings, 0, 1, test_board(), std::nullopt);
  ASSERT_TRUE(blind);
  EXPECT_GT(blind->runner_up, 0.8);
  // Both explain the board as well, and either is what a guess near it leads to.
  const SE3& T_camera_board = world.sightings[0].T_sensor_board;
  const SE3 half_turn{exp_so3(Vector3d(0.0, 0.0, pi)), Vector3d::Zero()};
  const SE3 turned = world.T_lidar_camera * T_camera_board * half_turn * T_camera_board.inverse();
  for (const SE3& T : {world.T_lidar_camera, turned}) {
    const SE3 guess = T * SE3{exp_so3(Vector3d(0.1, -0.1, 0.1)), Vector3d(0.1, 0.1, -0.1)};
    const auto guided = place_pair(world.sightings, 0, 1, test_board(), guess);
    ASSERT_TRUE(guided);
    EXPECT_EQ(guided->runner_up, 0.0);
    EXPECT_LT(rotation_distance(guided->T_a_b.R, T.R), to_rad(3.0));
  }
}

TEST(PlacePair, TellsBoardsSideBySideByAGuess) {
  Random random(11);
  World world = make_world(1, 0.0, random);
  ASSERT_EQ(world.sightings.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    BoardSighting& first = world.sightings[k];
    first.alternatives = {SE3{}};
    for (const double shift_m : {0.8, 1.6}) {
      BoardSighting beside = world.sightings[k];
      beside.T_sensor_board = beside.T_sensor_board * SE3{Matrix3d::Identity(), Vector3d(shift_m, 0.0, 0.0)};
      world.sightings.push_back(beside);
    }
  }
  const auto blind = place_pair(world.sightings, 0, 1, test_board(), std::nullopt);
  ASSERT_TRUE(blind);
  EXPECT_EQ(blind->runner_up, 1.0);
  for (const double shift_m : {0.0, 0.8, -1.6}) {
    const SE3& T_camera_board = world.sightings[0].T_sensor_board;
    const SE3 shift{Matrix3d::Identity(), Vector3d(shift_m, 0.0, 0.0)};
    const SE3 T = world.T_lidar_camera * T_camera_board * shift * T_camera_board.inverse();
    const auto guided =
        place_pair(world.sightings, 0, 1, test_board(), T * SE3{Matrix3d::Identity(), {0.1, 0.05, 0.0}});
    ASSERT_TRUE(guided);
    EXPECT_EQ(guided->runner_up, 0.0) << shift_m;
    EXPECT_LT((guided->T_a_b.t - T.t).norm(), 0.15) << shift_m;
  }
}

}  // namespace
}  // namespace rigcal
