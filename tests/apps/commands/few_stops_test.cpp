// Cameras of the shipped rig where hardly anything was recorded: one cloud and one image, or two.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/geometry/se3.h"
#include "core/io/extrinsics_file.h"
#include "tests/support/run_program.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;

class FewStops : public testing::Test {
 protected:
  [[nodiscard]] ProgramRun rigcal(const std::string& arguments) const { return run_rigcal(arguments, scratch_); }

  // The result of a simulated session whose sensors sit 3 degrees and 0.1 m off the rig file.
  [[nodiscard]] ExtrinsicsFile calibrated(const std::string& scene, int stops, int seed) {
    const ProgramRun made = rigcal(
        "simulate " + scene + " --rig '" RIGCAL_SOURCE_DIR "/config/rigs/turntable.yaml' --out " + scene + " --stops " +
        std::to_string(stops) + " --seed " + std::to_string(seed) + " --mount-error 100mm,3deg --quiet");
    EXPECT_EQ(made.code, 0) << made.err;
    const ProgramRun run = rigcal("calibrate " + scene + " --out " + scene + "/result");
    EXPECT_EQ(run.code, 1) << run.out << run.err;
    const auto result = load_extrinsics((scratch_ / scene / "result/extrinsics.yaml").string());
    const auto truth = load_extrinsics((scratch_ / scene / "ground_truth.yaml").string());
    if (!result || !truth) {
      ADD_FAILURE() << run.out << run.err;
      return {};
    }
    truth_ = *truth;
    return *result;
  }

  void expect_near_truth(const ExtrinsicsFile& result, const std::string& camera) const {
    ASSERT_EQ(result.status.at(camera), "weak");
    const SE3& T = result.T_base_sensor.at(camera);
    const SE3& expected = truth_.T_base_sensor.at(camera);
    EXPECT_LT((T.t - expected.t).norm(), 0.015) << camera;
    EXPECT_LT(to_deg(rotation_distance(T.R, expected.R)), 0.1) << camera;
    EXPECT_THAT(result.reasons.at(camera), Contains(HasSubstr("could be held out")));
  }

  fs::path scratch_ = scratch_folder("few_stops");
  ExtrinsicsFile truth_;
};

// No surface is seen twice: LiDARs say nothing of each other, but their map is there. One camera in five ends 15 to 90
// mm off in the courtyard (docs/judge-cameras.md); which, hangs on anything.
TEST_F(FewStops, OneIsEnoughForCamerasThatAreCalledWeak) {
  for (const char* scene : {"courtyard", "room"}) {
    const ExtrinsicsFile result = calibrated(scene, 1, 4);
    for (const char* camera : {"camera_left", "camera_right"}) expect_near_truth(result, camera);
    for (const char* lidar : {"mid100_left", "mid100_middle", "mid100_right"})
      EXPECT_EQ(result.status.at(lidar), "failed");
  }
}

// Edges alone explain more 95 mm away; grey values know better. Of two images one may contradict the other too far.
TEST_F(FewStops, OfTwoGreyValuesTellWhichPlaceIsTheRightOne) {
  const ExtrinsicsFile result = calibrated("courtyard", 2, 2);
  int placed = 0;
  for (const char* camera : {"camera_left", "camera_right"}) {
    if (result.status.at(camera) == "failed") continue;
    ++placed;
    expect_near_truth(result, camera);
  }
  EXPECT_GE(placed, 1);
}

}  // namespace
}  // namespace rigcal
