#include "core/quality/camera_verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

CameraEstimate sound() {
  CameraEstimate e;
  e.found = true;
  e.converged = true;
  e.pose.covariance.diagonal() << 1e-9, 1e-9, 1e-9, 1e-6, 1e-6, 1e-6;
  e.views = 20;
  e.views_with_edges = 20;
  e.hold_out = 1.1;
  e.hold_out_px = 0.3;
  e.hold_out_start_px = 12.0;
  e.focal_scale = {1e-4, 2e-4};
  e.k1_change = {1e-4, 5e-4};
  e.radial_trend = {0.02, 0.02};
  e.information = PoseEstimate{e.pose.T_base_camera, e.pose.covariance};
  e.disagreement_chi2 = 5.0;
  e.halves_m = 0.002;
  e.halves_rad = to_rad(0.01);
  e.runner_up = SE3{Matrix3d::Identity(), Vector3d(0.1, 0.0, 0.0)};
  e.runner_up_ratio = 0.6;
  e.hold_out_share = 0.9;
  for (int stop = 0; stop < 12; ++stop) e.stops.push_back({stop, std::to_string(stop) + ".png", 40.0, 12.0, 2.0, 10.0});
  e.first_and_last = {0.003, to_rad(0.02), 6.0, 1.02};
  return e;
}

Verdict judge(const CameraEstimate& e, bool refined = false) { return judge_camera(e, "left", {}, refined); }

void expect_weak(const CameraEstimate& e, const std::string& reason) {
  const Verdict verdict = judge(e);
  EXPECT_EQ(verdict.status, Status::weak) << reason;
  ASSERT_THAT(verdict.reasons, ElementsAre(HasSubstr(reason)));
  EXPECT_THAT(verdict.reasons[0], HasSubstr("; ")) << "it has no mend";
}

TEST(CameraVerdict, FindsNothingWrongWithASoundCamera) {
  EXPECT_EQ(judge(sound()).status, Status::good);
  EXPECT_THAT(judge(sound()).reasons, IsEmpty());
}

TEST(CameraVerdict, FailsWhatWasNotFoundWithItsReason) {
  CameraEstimate e;
  e.why_not = "no edge was matched";
  EXPECT_EQ(judge(e).status, Status::failed);
  EXPECT_THAT(judge(e).reasons, ElementsAre("no edge was matched"));
}

TEST(CameraVerdict, FailsWhatDoesNotConverge) {
  CameraEstimate e = sound();
  e.converged = false;
  EXPECT_EQ(judge(e).status, Status::failed);
  EXPECT_THAT(judge(e).reasons, ElementsAre(HasSubstr("still moved")));
}

TEST(CameraVerdict, FailsWhatIsNoNumber) {
  CameraEstimate e = sound();
  e.pose.covariance(4, 4) = std::nan("");
  EXPECT_EQ(judge(e).status, Status::failed);
  EXPECT_THAT(judge(e).reasons, ElementsAre(HasSubstr("is no number")));
  e = sound();
  e.pose.T_base_camera.t.x() = std::nan("");
  EXPECT_EQ(judge(e).status, Status::failed);
}

TEST(CameraVerdict, SaysWhyNothingWasHeldOut) {
  CameraEstimate e = sound();
  e.hold_out = 0.0;
  expect_weak(e, "too few edges were seen in the stops that were held out");
  e.information.reset();
  EXPECT_EQ(judge(e).status, Status::failed);
  EXPECT_THAT(judge(e).reasons, ElementsAre(HasSubstr("nothing confirms it")));
  e.views = 3;
  expect_weak(e, "too few stops (3 images)");
}

TEST(CameraVerdict, FailsWhatIsWorseThanItsStart) {
  CameraEstimate e = sound();
  e.hold_out_px = 18.2;
  EXPECT_EQ(judge(e).status, Status::failed);
  EXPECT_THAT(judge(e).reasons, ElementsAre(HasSubstr("18.20 px) than its start did (12.00 px")));
  // A start that was a result before is as good as the new one, but for noise.
  e = sound();
  e.hold_out_start_px = 0.28;
  EXPECT_EQ(judge(e).status, Status::good);
}

TEST(CameraVerdict, WeakensWideBounds) {
  CameraEstimate e = sound();
  e.pose.covariance(3, 3) = 1e-4;
  expect_weak(e, "translation is known to 28.0 mm only");
  e = sound();
  e.pose.covariance(1, 1) = 1e-6;
  expect_weak(e, "rotation is known to 0.160 degrees only");
}

TEST(CameraVerdict, WeakensAHoldOutBeyondNoiseAndNone) {
  CameraEstimate e = sound();
  e.hold_out = 2.4;
  expect_weak(e, "held-out stops disagree: 0.30 px, 2.4 times");
  e = sound();
  e.hold_out = e.hold_out_px = e.hold_out_start_px = 0.0;
  e.views = 1;
  expect_weak(e, "(1 image)");
}

TEST(CameraVerdict, WeakensHeldOutStopsThatShowLittleOfWhatIsExpected) {
  CameraEstimate e = sound();
  e.hold_out_share = 0.12;
  expect_weak(e, "held out show 12 % of the edges");
  e.hold_out_share = -0.02;
  expect_weak(e, "held out show 0 % of the edges");
  // The files say more.
  e.stops[3].explained = e.stops[7].explained = 3.0;
  expect_weak(e, "its images 3.png, 7.png show next to none of the edges");
}

TEST(CameraVerdict, WeakensStopsThatAreUnlikeTheOthers) {
  CameraEstimate e = sound();
  e.stops[8].explained = 2.5;
  EXPECT_EQ(judge(e).status, Status::good) << "one may have somebody before the camera";
  EXPECT_THAT(unlike_images(e), ElementsAre("8.png"));
  e.stops[9].explained = 5.4;
  expect_weak(e, "its images 8.png, 9.png show");
  e.stops[9].explained = 5.6;
  EXPECT_EQ(judge(e).status, Status::good) << "more than a third of what is expected";
  for (int stop = 12; stop < 40; ++stop) {
    e.stops.push_back({stop, std::to_string(stop) + ".png", 40.0, 12.0, 2.0, 10.0});
  }
  e.stops[9].explained = 2.0;
  EXPECT_EQ(judge(e).status, Status::good) << "two of forty";
  for (std::size_t k = 10; k < 18; ++k) e.stops[k].explained = 2.0;
  expect_weak(e, "8.png, 9.png, 10.png, 11.png, 12.png, 13.png and 4 more show");
}

TEST(CameraVerdict, ExpectsNothingOfAPlaceThatNoImageShows) {
  CameraEstimate e = sound();
  for (const std::size_t k : {4U, 5U, 6U}) {
    e.stops[k].explained = 2.1;
    e.stops[k].expected = 0.9;
  }
  EXPECT_EQ(judge(e).status, Status::good);
  EXPECT_THAT(unlike_images(e), IsEmpty());
}

TEST(CameraVerdict, WeakensACameraThatWasMovedOnTheWay) {
  const FirstAndLast moved{0.033, to_rad(0.26), 2557.0, 1.9};
  CameraEstimate e = sound();
  e.first_and_last = moved;
  expect_weak(e, "give poses 33.0 mm and 0.260 degrees apart");
  e.information.reset();
  EXPECT_EQ(judge(e).status, Status::failed) << "and nothing confirms it";
  EXPECT_THAT(judge(e).reasons, ElementsAre(AllOf(HasSubstr("a false match, or it was moved"),
                                                  HasSubstr("intrinsics of another lens, or of another image size"))));
  e.first_and_last.apart_m = 0.025;
  e.first_and_last.apart_rad = to_rad(0.2);
  expect_weak(e, "give poses 25.0 mm");
  e = sound();
  e.first_and_last = moved;
  e.first_and_last.gain = 1.1;
  EXPECT_EQ(judge(e).status, Status::good) << "where they explain no more, they ended at a false match";
  e.first_and_last = moved;
  e.first_and_last.chi2 = 15.0;
  EXPECT_EQ(judge(e).status, Status::good) << "they know no better";
  e.first_and_last = moved;
  e.first_and_last.apart_m = 0.005;
  e.first_and_last.apart_rad = to_rad(0.03);
  EXPECT_EQ(judge(e).status, Status::good) << "within what is asked for";
}

TEST(CameraVerdict, AsksMoreOfFirstAndLastStopsThatAreFew) {
  CameraEstimate e = sound();
  e.first_and_last = {0.016, to_rad(0.18), 300.0, 1.6};
  EXPECT_EQ(judge(e).status, Status::good) << "four stops each, a second sign is missing";
  e.halves_m = 0.014;
  EXPECT_THAT(judge(e).reasons,
              ElementsAre(AllOf(HasSubstr("give poses 16.0 mm"), HasSubstr("it may have been moved or bumped")),
                          HasSubstr("either half of its stops")));
  e.halves_m = 0.002;
  e.first_and_last.apart_m = 0.021;
  expect_weak(e, "give poses 21.0 mm");
  e.first_and_last.apart_m = 0.016;
  for (int stop = 12; stop < 15; ++stop) {
    e.stops.push_back({stop, std::to_string(stop) + ".png", 40.0, 12.0, 2.0, 10.0});
  }
  expect_weak(e, "give poses 16.0 mm");
}

TEST(CameraVerdict, WeakensIntrinsicsThatAreNotTheLenss) {
  CameraEstimate e = sound();
  e.focal_scale = {-0.01, 0.001};
  expect_weak(e, "a focal length 1.00 % shorter");
  e = sound();
  e.k1_change = {0.05, 0.004};
  expect_weak(e, "k1 larger by 0.0500");
  e = sound();
  e.cx_change_px = {0.2, 0.3};
  e.cy_change_px = {-3.0, 0.4};
  expect_weak(e, "a principal point that is 0.20 px farther right and 3.00 px farther up than the rig file's");
  CameraThresholds of_quarter_images;
  of_quarter_images.centre_chance_px *= 8.0;
  EXPECT_EQ(judge_camera(e, "left", {}, false, of_quarter_images).status, Status::good) << "0.4 px of those";
  e = sound();
  e.radial_trend = {-1.5, 0.1};
  expect_weak(e, "along the radius, 1.50 px at the corners");
}

TEST(CameraVerdict, NamesIntrinsicsFirstAndOnceAndAFalseMatchWhereOpinionsDiffer) {
  CameraEstimate e = sound();
  e.focal_scale = {-0.01, 0.001};
  e.radial_trend = {-1.5, 0.1};
  EXPECT_THAT(judge(e).reasons, testing::ElementsAre(testing::EndsWith("or try --refine-intrinsics")));
  e.halves_m = 0.5;
  const std::vector<std::string> reasons = judge(e).reasons;
  ASSERT_EQ(reasons.size(), 2U);
  EXPECT_THAT(reasons[0], testing::HasSubstr("unless the overlays in report.html show a false match"));
  EXPECT_THAT(reasons[1], testing::HasSubstr("either half of its stops gives another pose"));
}

// Where nothing else confirms such a pose it is none.
TEST(CameraVerdict, FailsWhatHalvesAndLensSpeakAgainst) {
  CameraEstimate e = sound();
  e.k1_change = {0.05, 0.004};
  e.halves_m = 0.02;
  EXPECT_EQ(judge(e).status, Status::weak);
  e.information->T_base_camera.t += Vector3d(0.0, 0.02, 0.0);  // not sure of it, but no confirmation either
  EXPECT_EQ(judge(e).status, Status::failed);
  EXPECT_THAT(judge(e).reasons, ElementsAre(HasSubstr("another lens than the rig file's")));
  EXPECT_EQ(judge(e, true).status, Status::weak);
  e.halves_m = 0.002;
  EXPECT_EQ(judge(e).status, Status::weak);
}

TEST(CameraVerdict, FailsWhatHalvesSpeakAgainstAndGreyValuesKnowNothingOf) {
  CameraEstimate e = sound();
  e.halves_rad = to_rad(0.2);
  EXPECT_EQ(judge(e).status, Status::weak);
  e.information.reset();
  EXPECT_EQ(judge(e).status, Status::failed);
  EXPECT_THAT(judge(e).reasons,
              ElementsAre(AllOf(HasSubstr("grey values lead nowhere"),
                                HasSubstr("intrinsics of another lens, or of another image size, do that"))));
  e.halves_rad = to_rad(0.05);
  EXPECT_EQ(judge(e).status, Status::good);
}

TEST(CameraVerdict, FailsWhatHalvesAloneSpeakAgainstFromAfar) {
  CameraEstimate e = sound();
  e.halves_m = 0.035;
  EXPECT_EQ(judge(e).status, Status::weak);
  e.information->T_base_camera.t += Vector3d(0.0, 0.02, 0.0);
  EXPECT_EQ(judge(e).status, Status::failed);
  e.halves_m = 0.025;
  EXPECT_EQ(judge(e).status, Status::weak);
}

TEST(CameraVerdict, AsksFirstAboutTheModelOfALensThatAnotherOneExplainsBetter) {
  CameraEstimate e = sound();
  e.other_lens_gain = 2.0;
  EXPECT_EQ(judge(e).status, Status::good);
  EXPECT_THAT(judge(e).reasons, IsEmpty());
  e.halves_m = 0.02;
  EXPECT_EQ(judge(e).status, Status::weak);
  EXPECT_THAT(judge(e).reasons, ElementsAre(HasSubstr("an equidistant (fisheye) lens of its focal length explains"),
                                            HasSubstr("either half of its stops")));
  e.converged = false;
  e.intrinsics.model = DistortionModel::equidistant;
  EXPECT_EQ(judge(e).status, Status::failed);
  EXPECT_THAT(judge(e).reasons, ElementsAre(HasSubstr("a radtan lens"), HasSubstr("still moved")));
  e.other_lens_gain = 1.05;
  EXPECT_THAT(judge(e).reasons, ElementsAre(HasSubstr("still moved")));
}

TEST(CameraVerdict, LetsIntrinsicsChangeThatWereToBeFound) {
  CameraEstimate e = sound();
  e.focal_scale = {-0.01, 0.001};
  e.k1_change = {0.05, 0.004};
  EXPECT_EQ(judge(e, true).status, Status::good);
}

TEST(CameraVerdict, WeakensOpinionsThatDiffer) {
  CameraEstimate e = sound();
  e.information->T_base_camera.t = Vector3d(0.03, 0.0, 0.0);
  e.disagreement_chi2 = 60.0;
  expect_weak(e, "its edges and its grey values disagree by 30.0 mm");
  e = sound();
  e.halves_m = 0.02;
  expect_weak(e, "either half of its stops");
  e = sound();
  e.halves_rad = to_rad(0.3);
  expect_weak(e, "0.300 degrees apart");
  e = sound();
  e.runner_up_ratio = 0.98;
  expect_weak(e, "another pose, 100.0 mm");
  e.runner_up_ratio = 0.8;
  EXPECT_EQ(judge(e).status, Status::good);
  e.information->T_base_camera.t = Vector3d(0.03, 0.0, 0.0);
  expect_weak(e, "fits well, too, and grey values do not lead to this one (80 %)");
}

TEST(CameraVerdict, OfOneImageNamesAnotherPoseBeforeTheBounds) {
  CameraEstimate e = sound();
  e.information.reset();
  e.views = 1;
  e.hold_out = 0.0;
  e.pose.covariance = 1e-3 * Matrix6d::Identity();
  const auto first_reason = [&] { return judge(e).reasons.at(0); };
  EXPECT_THAT(first_reason(), testing::HasSubstr("its translation is known to"));
  e.runner_up_ratio = 0.8;
  EXPECT_EQ(judge(e).status, Status::weak);
  EXPECT_THAT(first_reason(), testing::HasSubstr("fits well, too, and nothing tells which is right (80 %)"));
}

TEST(CameraVerdict, FailsWhereHalvesOfTheStopsDifferByFarMoreThanTheyMay) {
  CameraEstimate e = sound();
  e.halves_chi2 = 20.0;
  EXPECT_EQ(judge(e).status, Status::good);
  e.halves_chi2 = 40.0;
  EXPECT_EQ(judge(e).status, Status::good);  // grey values say the same
  e.information.reset();
  e.focal_scale = {-0.01, 0.001};  // may seem so at a false match
  const Verdict verdict = judge(e);
  EXPECT_EQ(verdict.status, Status::failed);
  EXPECT_THAT(verdict.reasons, testing::ElementsAre(testing::HasSubstr("a false match, or it moved")));
}

}  // namespace
}  // namespace rigcal
