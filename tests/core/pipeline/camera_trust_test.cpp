#include "core/pipeline/camera_trust.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/pipeline/lidar_result.h"
#include "core/quality/verdict_text.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Five stops of given poses, to 5 cm and 2 degrees, all with an image and the first `clouds` of them with a cloud.
struct GivenRun {
  explicit GivenRun(int clouds) {
    for (int stop = 0; stop < 5; ++stop) {
      recording.stops.push_back({stop, 0, 0});
      solution.adjust.stop_priors.push_back(isotropic_prior(SE3{}, to_rad(2.0), 0.05));
      views.push_back({stop, "", {}, nullptr});
    }
    for (int stop = 0; stop < clouds; ++stop) {
      recording.patches.push_back({0, stop, 0, {Cell{}}, {}, {}, 0});
      solution.use.push_back(1);
    }
    recording.trajectory_is_prior = true;
    camera.T_base_camera = {exp_so3({0.3, -0.2, 1.0}), {0.1, -0.2, 0.3}};
    camera.covariance = Matrix6d(1e-6 * Matrix6d::Identity());
  }
  void judge() { rest_on_given_stops(views, recording, solution, camera, verdict); }

  LidarRecording recording;
  LidarSolution solution{5, 1};
  std::vector<CameraView> views;
  PoseEstimate camera;
  Verdict verdict;
};

TEST(GivenStops, AreInTheSigmaOfACameraThatRestsOnThem) {
  GivenRun run(0);
  run.judge();
  EXPECT_EQ(run.verdict.status, Status::weak);
  EXPECT_THAT(run.verdict.reasons, ElementsAre(HasSubstr("5 of its 5 images come from stops without a cloud")));
  // All of them may err alike, so that five stops say no more than one.
  const Vector6d sigmas = run.camera.covariance.diagonal().cwiseSqrt();
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(sigmas[k], to_rad(2.0), 1e-4);
    EXPECT_GE(sigmas[3 + k], 0.05);
    EXPECT_LT(sigmas[3 + k], 0.055) << "and where it stands by how the base is turned";
  }
}

TEST(GivenStops, CountByTheirShareOfTheImages) {
  GivenRun run(4);
  run.recording.patches[3].cells.clear();
  run.judge();
  EXPECT_THAT(run.verdict.reasons, ElementsAre(HasSubstr("2 of its 5 images come from")));
  EXPECT_NEAR(std::sqrt(run.camera.covariance(0, 0)), to_rad(0.8), 1e-3);
}

TEST(GivenStops, AreNothingWhereCloudsHoldThemOrTheCameraFailed) {
  GivenRun held(5);
  held.judge();
  EXPECT_EQ(held.verdict.status, Status::good);
  EXPECT_EQ(held.camera.covariance(3, 3), 1e-6);
  GivenRun failed(0);
  fail(failed.verdict, "no edges");
  failed.judge();
  EXPECT_EQ(failed.verdict.reasons.size(), 1U);
}

TEST(UnevenSurfaces, WidenACameraByTheStopsOfItsImages) {
  GivenRun run(5);
  const Matrix6d even = run.camera.covariance;
  widen_by_unevenness(run.views, run.solution, run.camera);
  EXPECT_EQ(run.camera.covariance, even);
  run.solution.unevenness_m = 0.01;
  run.views.push_back(run.views[0]);
  widen_by_unevenness(run.views, run.solution, run.camera);
  EXPECT_NEAR(run.camera.covariance(3, 3) - even(3, 3), 1e-4 / 5.0, 1e-12) << "two images of one stop are one";
  EXPECT_NEAR(run.camera.covariance(0, 0) - even(0, 0), 1e-4 / 5.0 / 25.0, 1e-12);
}

}  // namespace
}  // namespace rigcal
