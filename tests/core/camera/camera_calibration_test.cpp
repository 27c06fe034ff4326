#include "core/camera/camera_calibration.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/camera/camera_minima.h"
#include "core/geometry/matrix6.h"
#include "tests/core/camera/box_room.h"

namespace rigcal {
namespace {

const BoxRoom& room() {
  static const BoxRoom room;
  return room;
}

// One camera's images take a while to cast; the guess is put in afterwards.
CameraTask task_from(const SE3& guess) {
  static const CameraTask task = room().task(BoxRoom::truth());
  CameraTask copy = task;
  copy.guess_T_base_camera = guess;
  return copy;
}

CameraEstimate calibrate_in(const CameraScene& scene, const CameraTask& task,
                            const CameraCalibrationOptions& options = {}) {
  SilentReporter reporter;
  const auto estimate = calibrate_camera(scene, task, options, RunContext{reporter});
  EXPECT_TRUE(estimate);
  return estimate ? *estimate : CameraEstimate{};
}

CameraEstimate calibrate(const CameraTask& task, const CameraCalibrationOptions& options = {}) {
  return calibrate_in(room().scene, task, options);
}

double offset_m(const SE3& T) { return (T.t - BoxRoom::truth().t).norm(); }
double offset_rad(const SE3& T) { return rotation_distance(T.R, BoxRoom::truth().R); }

double shown_of_all(const StopAgreement& stop) { return stop.more_than_chance() / stop.segments; }
double shown_of_expected(const StopAgreement& stop) { return stop.more_than_chance() / stop.expected; }

TEST(CameraCalibration, ComesBackFromFiveDegreesAndTenCentimetres) {
  double nees = 0.0;
  constexpr int trials = 4;
  for (std::uint64_t seed = 1; seed <= trials; ++seed) {
    const CameraEstimate estimate = calibrate(task_from(BoxRoom::spoiled(to_rad(5.0), 0.1, seed)));
    ASSERT_TRUE(estimate.found) << estimate.why_not;
    EXPECT_TRUE(estimate.converged);
    EXPECT_LT(offset_m(estimate.pose.T_base_camera), 0.004);
    EXPECT_LT(offset_rad(estimate.pose.T_base_camera), to_rad(0.05));
    const Vector6d xi = (BoxRoom::truth().inverse() * estimate.pose.T_base_camera).log();
    nees += xi.dot(solve_symmetric6(estimate.pose.covariance, xi)) / 6.0 / trials;
    EXPECT_LT(std::abs(estimate.focal_scale.value), 3.0 * estimate.focal_scale.sigma);
    EXPECT_LT(std::abs(estimate.k1_change.value), 3.0 * estimate.k1_change.sigma);
    EXPECT_LT(estimate.residual_px, 0.4);
    EXPECT_LT(estimate.hold_out, 1.5);
    EXPECT_GT(estimate.hold_out_start_px, 5.0 * estimate.hold_out_px);
    EXPECT_LT(estimate.halves_m, 0.01);
    EXPECT_LT(estimate.runner_up_ratio, 0.8);
    EXPECT_EQ(estimate.views, BoxRoom::stops);
    EXPECT_EQ(estimate.views_with_edges, BoxRoom::stops);
  }
  EXPECT_LT(nees, 2.0);
}

// Half a metre off edges explained as much as they did anywhere near the guess; the images alone lead back.
TEST(CameraCalibration, LooksElsewhereWhereTheEndIsDoubtful) {
  const CameraEstimate estimate = calibrate(task_from(BoxRoom::spoiled(to_rad(18.0), 0.3, 3)));
  ASSERT_TRUE(estimate.found) << estimate.why_not;
  EXPECT_LT(offset_m(estimate.pose.T_base_camera), 0.004);
  EXPECT_LT(offset_rad(estimate.pose.T_base_camera), to_rad(0.05));
  EXPECT_LT(estimate.runner_up_ratio, 0.8);
  ASSERT_TRUE(estimate.runner_up);
  EXPECT_FALSE(is_within(*estimate.runner_up, estimate.pose.T_base_camera, to_rad(0.2), 0.03)) << "it is another pose";
}

TEST(CameraCalibration, ChecksByTheStopsThatHaveImages) {
  CameraTask task = task_from(BoxRoom::spoiled(to_rad(2.0), 0.03, 4));
  std::erase_if(task.views, [](const CameraView& view) { return view.stop % 2 == 0; });
  const CameraEstimate odd = calibrate(task);
  ASSERT_TRUE(odd.found) << odd.why_not;
  EXPECT_GT(odd.hold_out, 0.0);
  EXPECT_GT(odd.halves_m, 0.0);
  task = task_from(BoxRoom::spoiled(to_rad(2.0), 0.03, 4));
  std::erase_if(task.views, [](const CameraView& view) { return view.stop == 3 || view.stop > 4; });
  ASSERT_EQ(task.views.size(), 4U);
  EXPECT_GT(calibrate(task).hold_out, 0.0) << "of four the last is held out, whatever its number";
}

TEST(CameraCalibration, SeesThatHalvesOfTheStopsDifferWhereTheCameraSways) {
  const BoxRoom room(12);
  const SE3 guess = BoxRoom::spoiled(to_rad(2.0), 0.03, 4);
  const CameraEstimate still = calibrate_in(room.scene, room.task(guess));
  ASSERT_TRUE(still.found) << still.why_not;
  EXPECT_GT(still.halves_chi2, 0.0);
  EXPECT_LT(still.halves_chi2, 12.0);
  Vector6d sway = Vector6d::Zero();
  sway[1] = to_rad(0.5);
  const CameraEstimate loose = calibrate_in(room.scene, room.task(guess, 1, SE3::exp(sway)));
  ASSERT_TRUE(loose.found) << loose.why_not;
  EXPECT_NEAR(loose.halves_rad, to_rad(0.5), to_rad(0.1));
  EXPECT_GT(loose.halves_chi2, 100.0);
}

// The offsets of what finds a partner are small in a wrong image, too: that little does is what tells.
TEST(CameraCalibration, SeesThatHeldOutStopsShowAnotherPlace) {
  CameraTask task = task_from(BoxRoom::spoiled(to_rad(2.0), 0.03, 4));
  const CameraEstimate sound = calibrate(task);
  ASSERT_TRUE(sound.hold_out_share);
  EXPECT_NEAR(*sound.hold_out_share, 1.0, 0.3);
  EXPECT_LT(sound.first_and_last.gain, 1.1);
  ASSERT_EQ(sound.stops.size(), static_cast<std::size_t>(BoxRoom::stops));
  for (const StopAgreement& stop : sound.stops) EXPECT_GT(shown_of_all(stop), 0.3) << stop.file;
  task.views[3].grey = task.views[0].grey;
  task.views[7].grey = task.views[4].grey;
  const CameraEstimate estimate = calibrate(task);
  ASSERT_TRUE(estimate.found) << estimate.why_not;
  EXPECT_LT(offset_m(estimate.pose.T_base_camera), 0.006) << "the others hold it";
  ASSERT_TRUE(estimate.hold_out_share);
  EXPECT_LT(*estimate.hold_out_share, 0.2);
  EXPECT_EQ(estimate.stops[3].file, "3.png");
  for (const StopAgreement& stop : estimate.stops) {
    EXPECT_EQ(shown_of_all(stop) < 0.1, stop.stop == 3 || stop.stop == 7) << stop.file << ": " << shown_of_all(stop);
    EXPECT_EQ(shown_of_expected(stop) < 0.3, stop.stop == 3 || stop.stop == 7) << stop.file;
  }
}

// A wall that has more lines than images show, as one of bricks in one grey.
TEST(CameraCalibration, ExpectsNoLinesThatNoImageShows) {
  CameraScene scene = room().scene;
  const int lines = std::max_element(scene.edges.begin(), scene.edges.end(), [](const auto& a, const auto& b) {
                      return a.line < b.line;
                    })->line;
  const std::vector<LidarEdge> seen = scene.edges;
  for (LidarEdge edge : seen) {
    if (std::hypot(edge.p_G.x() - 3.4, edge.p_G.y() - 2.4) > 0.01) continue;
    for (int k = 1; k <= 15; ++k) {
      edge.p_G.y() -= 0.25;
      edge.line = lines + k;
      scene.edges.push_back(edge);
    }
  }
  ASSERT_GT(scene.edges.size(), seen.size()) << "the corner is where it is looked for";
  const CameraEstimate estimate = calibrate_in(scene, task_from(BoxRoom::spoiled(to_rad(2.0), 0.03, 4)));
  ASSERT_TRUE(estimate.found) << estimate.why_not;
  double least = 1.0;
  double most = 0.0;
  for (const StopAgreement& stop : estimate.stops) {
    least = std::min(least, shown_of_all(stop));
    most = std::max(most, shown_of_all(stop));
    EXPECT_GT(shown_of_expected(stop), 0.6) << stop.file;
  }
  EXPECT_LT(least, 0.5 * most) << "whose share tells of the wall, not of the image";
}

// The last quarter: each of its stops has others beside it that show as little.
TEST(CameraCalibration, AsksNoStopsThatAreThemselvesInDoubt) {
  const BoxRoom room(12);
  const SE3 guess = BoxRoom::spoiled(to_rad(2.0), 0.03, 4);
  Vector6d turn = Vector6d::Zero();
  turn[0] = turn[1] = to_rad(2.0);
  const CameraEstimate sound = calibrate_in(room.scene, room.task(guess));
  const CameraEstimate turned = calibrate_in(room.scene, room.task(guess, 1, SE3::exp(turn), 9));
  ASSERT_TRUE(turned.found) << turned.why_not;
  ASSERT_EQ(turned.stops.size(), sound.stops.size());
  for (std::size_t k = 0; k < turned.stops.size(); ++k) {
    EXPECT_EQ(shown_of_expected(turned.stops[k]) < 0.3, k >= 9) << k;
    EXPECT_NEAR(turned.stops[k].expected, sound.stops[k].expected, 0.3 * sound.stops[k].expected) << k;
  }
}

TEST(CameraCalibration, SeesThatTheCameraWasTurnedOnTheWay) {
  const BoxRoom room(12);
  const SE3 guess = BoxRoom::spoiled(to_rad(2.0), 0.03, 4);
  Vector6d turn = Vector6d::Zero();
  turn[1] = to_rad(1.0);
  CameraTask task = room.task(guess, 1, SE3::exp(turn), 7);
  const CameraEstimate turned = calibrate_in(room.scene, task);
  ASSERT_TRUE(turned.found) << turned.why_not;
  EXPECT_NEAR(turned.first_and_last.apart_rad, to_rad(1.0), to_rad(0.2));
  EXPECT_GT(turned.first_and_last.chi2, 100.0);
  EXPECT_GT(turned.first_and_last.gain, 1.3);
}

// Too little to be told from chance; it goes into the pose, and so its sigma must hold it.
TEST(CameraCalibration, SigmaHoldsAShiftOfAllImages) {
  CameraTask task = task_from(BoxRoom::spoiled(to_rad(2.0), 0.03, 4));
  const CameraEstimate sound = calibrate(task);
  constexpr double shift_px = 0.4;
  task.intrinsics.cx += shift_px;
  task.intrinsics.cy += shift_px;
  const CameraEstimate shifted = calibrate(task);
  ASSERT_TRUE(sound.found && shifted.found);
  const Vector6d apart = (sound.pose.T_base_camera.inverse() * shifted.pose.T_base_camera).log();
  EXPECT_GT(apart.head<3>().norm(), 0.5 * shift_px / task.intrinsics.fx);
  // Four sigmas along either axis of the image, were nothing else uncertain.
  EXPECT_LT(apart.dot(solve_symmetric6(sound.pose.covariance, apart)), 2.0 * std::pow(shift_px / 0.1, 2));
}

TEST(CameraCalibration, SeesWrongIntrinsicsAndMendsThemIfAsked) {
  CameraTask task = task_from(BoxRoom::spoiled(to_rad(2.0), 0.05, 5));
  task.intrinsics.fx *= 1.01;
  task.intrinsics.fy *= 1.01;
  const CameraEstimate focal = calibrate(task);
  ASSERT_TRUE(focal.found);
  EXPECT_LT(focal.focal_scale.value, -3.0 * focal.focal_scale.sigma);
  EXPECT_EQ(focal.intrinsics.fx, task.intrinsics.fx);
  EXPECT_LT(offset_m(focal.pose.T_base_camera), 0.008);
  CameraCalibrationOptions refine;
  refine.refine_intrinsics = true;
  const CameraEstimate mended = calibrate(task, refine);
  ASSERT_TRUE(mended.found);
  EXPECT_NEAR(mended.intrinsics.fx, BoxRoom::intrinsics().fx, 0.0015 * BoxRoom::intrinsics().fx);
  EXPECT_LT(offset_m(mended.pose.T_base_camera), 0.006);

  task = task_from(BoxRoom::spoiled(to_rad(2.0), 0.05, 6));
  task.intrinsics.distortion[0] += 0.05;
  const CameraEstimate bent = calibrate(task);
  ASSERT_TRUE(bent.found);
  EXPECT_LT(bent.k1_change.value, -3.0 * bent.k1_change.sigma);
  EXPECT_EQ(bent.intrinsics.distortion[0], task.intrinsics.distortion[0]);
}

TEST(CameraCalibration, SeesThatALensOfTheOtherModelExplainsMore) {
  CameraTask task = task_from(BoxRoom::spoiled(to_rad(2.0), 0.05, 5));
  EXPECT_EQ(calibrate(task).other_lens_gain, 0.0) << "nothing asks for it";
  task.intrinsics.model = DistortionModel::equidistant;
  task.intrinsics.distortion.assign(4, 0.0);
  EXPECT_GT(calibrate(task).other_lens_gain, 1.1);
  task = task_from(BoxRoom::spoiled(to_rad(2.0), 0.05, 5));
  task.intrinsics.distortion[0] += 0.05;
  const CameraEstimate bent = calibrate(task);
  EXPECT_GT(bent.other_lens_gain, 0.0);
  EXPECT_LT(bent.other_lens_gain, 0.9) << "its own model, with another k1, is right";
}

TEST(CameraCalibration, TellsWhyItCannot) {
  CameraTask task = task_from(BoxRoom::truth());
  task.guess_T_base_camera.reset();
  task.views.resize(1);
  EXPECT_NE(calibrate(task).why_not.find("give one under initial_extrinsics"), std::string::npos) << "no turn to see";

  task = task_from(BoxRoom::truth());
  task.views.clear();
  EXPECT_NE(calibrate(task).why_not.find("no image"), std::string::npos);

  task = task_from(BoxRoom::truth());
  for (CameraView& view : task.views) std::fill(view.grey.values.begin(), view.grey.values.end(), 3.0F);
  const CameraEstimate black = calibrate(task);
  EXPECT_FALSE(black.found);
  EXPECT_NE(black.why_not.find("black"), std::string::npos);

  task = task_from(BoxRoom::truth());
  for (CameraView& view : task.views) view.stop = 100;
  EXPECT_FALSE(calibrate(task).found);
}

TEST(CameraCalibration, FindsNothingInAnEmptyMapOrBehindTheCamera) {
  CameraScene scene = room().scene;
  // The only edges lie where the camera's single image does not look.
  CameraTask task = task_from(BoxRoom::truth());
  task.views.resize(1);
  const Vector3d forward = (scene.T_G_base[0] * BoxRoom::truth()).R.col(2);
  std::erase_if(scene.edges, [&](const LidarEdge& edge) { return edge.p_G.dot(forward) > 0.0; });
  ASSERT_FALSE(scene.edges.empty());
  SilentReporter reporter;
  const auto estimate = calibrate_camera(scene, task, {}, RunContext{reporter});
  ASSERT_TRUE(estimate);
  EXPECT_FALSE(estimate->found);
  EXPECT_NE(estimate->why_not.find("too few edges"), std::string::npos);
  EXPECT_TRUE(std::isfinite(estimate->wall_s));
}

// As when its images are tried at stops that are not theirs.
TEST(CameraCalibration, IsGivenUpAtAStartThatExplainsLessThanWasFoundBefore) {
  CameraTask task = task_from(BoxRoom::spoiled(to_rad(2.0), 0.03, 9));
  const CameraEstimate own = calibrate(task);
  ASSERT_TRUE(own.found) << own.why_not;
  EXPECT_GT(own.start_score, 0.3);
  EXPECT_LE(own.start_score, 1.0);
  EXPECT_TRUE(calibrate(task, {.beaten_start_score = 0.9 * own.start_score}).found);
  for (CameraView& view : task.views) view.stop = (view.stop + 1) % BoxRoom::stops;
  const CameraEstimate moved = calibrate(task, {.beaten_start_score = own.start_score});
  EXPECT_FALSE(moved.found);
  EXPECT_LT(moved.start_score, own.start_score);
  EXPECT_NE(moved.why_not.find("found before"), std::string::npos);
}

TEST(CameraCalibration, OneImageIsLessSureThanAll) {
  CameraTask task = task_from(BoxRoom::spoiled(to_rad(1.0), 0.02, 7));
  const CameraEstimate all = calibrate(task);
  task.views.resize(1);
  const CameraEstimate one = calibrate(task);
  ASSERT_TRUE(all.found);
  if (!one.found) return;  // too few edges in it: said so
  EXPECT_EQ(one.views, 1);
  EXPECT_GT(one.pose.covariance.trace(), all.pose.covariance.trace());
  EXPECT_GT(all.k1_change.sigma, 0.0);
  EXPECT_EQ(one.k1_change.sigma, 0.0) << "nothing could tell whether other intrinsics are better";
  EXPECT_EQ(one.focal_scale.sigma, 0.0);
}

TEST(CameraCalibration, IsTheSameOnAnyNumberOfThreads) {
  const int before = thread_count();
  const CameraTask task = task_from(BoxRoom::spoiled(to_rad(3.0), 0.08, 8));
  set_thread_count(1);
  const CameraEstimate one = calibrate(task);
  set_thread_count(4);
  const CameraEstimate four = calibrate(task);
  set_thread_count(before);
  ASSERT_TRUE(one.found);
  EXPECT_TRUE(one.pose.T_base_camera.R == four.pose.T_base_camera.R);
  EXPECT_TRUE(one.pose.T_base_camera.t == four.pose.T_base_camera.t);
  EXPECT_TRUE(one.pose.covariance == four.pose.covariance);
  EXPECT_EQ(one.hold_out, four.hold_out);
}

TEST(CameraCalibration, StopsWhenAsked) {
  SilentReporter reporter;
  std::stop_source source;
  source.request_stop();
  const auto estimate =
      calibrate_camera(room().scene, task_from(BoxRoom::truth()), {}, RunContext{reporter, source.get_token()});
  ASSERT_FALSE(estimate);
  EXPECT_EQ(estimate.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace rigcal
