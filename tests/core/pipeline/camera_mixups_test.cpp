#include "core/pipeline/camera_mixups.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Good, and found where `guess` is but for what it is off by.
SensorResult camera(const std::string& name, const SE3& guess, const Vector6d& off = Vector6d::Zero()) {
  SensorResult sensor{name, Status::good, {}, guess * SE3::exp(off), Matrix6d::Zero()};
  sensor.guess_T_base_sensor = guess;
  return sensor;
}

SE3 at(double y, double yaw_deg = 0.0) { return {exp_so3(to_rad(yaw_deg) * Vector3d::UnitZ()), {0.0, y, 0.0}}; }

void swap_places(SensorResult& a, SensorResult& b) { std::swap(a.T_base_sensor, b.T_base_sensor); }

void tell(std::vector<SensorResult>& cameras) { tell_mixed_up(std::vector<ImageMarks>(cameras.size()), {}, cameras); }

Vector6d off(double turn_deg, double way_m, std::uint64_t seed) {
  Random random(seed);
  const auto direction = [&] { return Vector3d(random.normal(), random.normal(), random.normal()).normalized(); };
  Vector6d xi;
  xi << to_rad(turn_deg) * direction(), way_m * direction();
  return xi;
}

CameraView view(int stop, float shade) {
  GreyImage grey{4, 5, std::vector<float>(20, 80.0F)};
  grey.values[2] = shade;
  return {stop, "x.png", grey, nullptr};
}

TEST(CameraMixups, TellOfTheSameImagesInTwoCameras) {
  const std::vector<ImageMarks> marks{
      image_marks({view(0, 1.0F), view(1, 2.0F), view(2, 3.0F)}),
      image_marks({view(0, 9.0F), view(1, 8.0F), view(2, 7.0F)}),
      image_marks({view(1, 2.0F), view(2, 3.0F), view(4, 5.0F)}),
  };
  std::vector<SensorResult> cameras{camera("left", at(0.1)), camera("middle", at(0.0)), camera("right", at(-0.1))};
  cameras[2].status = Status::failed;
  cameras[2].reasons = {"it fits nothing"};
  tell_mixed_up(marks, {}, cameras);
  EXPECT_EQ(cameras[0].status, Status::weak);
  EXPECT_THAT(cameras[0].reasons, ElementsAre(HasSubstr("those of right, too (the same in 2 of 2 stops)")));
  EXPECT_EQ(cameras[1].status, Status::good);
  EXPECT_EQ(cameras[2].status, Status::failed);
  EXPECT_THAT(cameras[2].reasons, ElementsAre(HasSubstr("those of left, too"), "it fits nothing"));
}

TEST(CameraMixups, LetAFewEqualImagesBe) {
  const std::vector<ImageMarks> marks{
      image_marks({view(0, 1.0F), view(1, 2.0F)}),
      image_marks({view(0, 1.0F), view(1, 3.0F)}),
      image_marks({view(5, 1.0F), view(6, 2.0F)}),
  };
  std::vector<SensorResult> cameras{camera("left", at(0.1)), camera("middle", at(0.0)), camera("right", at(-0.1))};
  tell_mixed_up(marks, {}, cameras);
  for (const SensorResult& sensor : cameras) EXPECT_THAT(sensor.reasons, IsEmpty()) << sensor.name;
}

TEST(CameraMixups, TellOfACameraThatHasOneImageInMostStops) {
  const std::vector<ImageMarks> marks{
      image_marks({view(0, 1.0F), view(1, 2.0F), view(2, 2.0F), view(3, 2.0F), view(4, 3.0F)}),
      image_marks({view(0, 4.0F), view(1, 4.0F), view(2, 5.0F), view(3, 5.0F), view(4, 6.0F)}),
      image_marks({view(0, 7.0F), view(1, 8.0F), view(2, 9.0F)}),
  };
  EXPECT_THAT(repeated_images(marks[0]), ElementsAre(1, 2, 3));
  EXPECT_THAT(repeated_images(marks[1]), ElementsAre(0, 1));
  EXPECT_THAT(repeated_images(marks[2]), IsEmpty());
  std::vector<SensorResult> cameras{camera("left", at(0.1)), camera("middle", at(0.0)), camera("right", at(-0.1))};
  tell_mixed_up(marks, {}, cameras);
  EXPECT_EQ(cameras[0].status, Status::weak);
  EXPECT_THAT(cameras[0].reasons, ElementsAre(HasSubstr("it has the same image at 3 of 5 stops")));
  EXPECT_EQ(cameras[1].status, Status::good);
  EXPECT_EQ(cameras[2].status, Status::good);
}

TEST(CameraMixups, TellOfCamerasThatStandWhereTheOtherShould) {
  std::vector<SensorResult> cameras{camera("left", at(0.06)), camera("other", at(0.3)), camera("right", at(-0.06))};
  swap_places(cameras[0], cameras[2]);
  tell(cameras);
  EXPECT_EQ(cameras[0].status, Status::weak);
  EXPECT_THAT(
      cameras[0].reasons,
      ElementsAre(HasSubstr("it stands where the rig file has right, 120.0 mm and 0.000 degrees from its own")));
  EXPECT_EQ(cameras[1].status, Status::good);
  EXPECT_THAT(cameras[2].reasons, ElementsAre(HasSubstr("it stands where the rig file has left")));
}

// Both look the same way, so that what their guesses are turned by speaks for neither.
TEST(CameraMixups, TellOfSwappedCamerasMostlyWhereGuessesAreAFewCentimetresAndDegreesOff) {
  int told = 0;
  constexpr int pairs = 200;
  for (std::uint64_t seed = 1; seed <= pairs; ++seed) {
    std::vector<SensorResult> cameras{camera("left", at(0.06), off(3.0, 0.05, seed)),
                                      camera("right", at(-0.06), off(3.0, 0.05, seed + 1000))};
    swap_places(cameras[0], cameras[1]);
    tell(cameras);
    if (cameras[0].status == Status::weak && cameras[1].status == Status::weak) ++told;
  }
  EXPECT_GT(told, 0.8 * pairs);
}

TEST(CameraMixups, TellOfSwappedCamerasByTheirTurnsToo) {
  std::vector<SensorResult> cameras{camera("left", at(0.0, 20.0), off(3.0, 0.05, 1)),
                                    camera("right", at(0.0, -20.0), off(3.0, 0.05, 2))};
  swap_places(cameras[0], cameras[1]);
  tell(cameras);
  EXPECT_THAT(cameras[0].reasons, ElementsAre(HasSubstr("where the rig file has right")));
  // One that was not found stands nowhere.
  std::vector<SensorResult> half{camera("left", at(0.0, 20.0)), camera("right", at(0.0, -20.0))};
  swap_places(half[0], half[1]);
  half[1].T_base_sensor.reset();
  tell(half);
  EXPECT_THAT(half[0].reasons, IsEmpty());
}

TEST(CameraMixups, AreNotWhereGuessesAreMerelyRough) {
  for (const double beside_m : {0.02, 0.06, 0.15}) {
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
      std::vector<SensorResult> cameras{camera("left", at(beside_m), off(5.0, 0.1, seed)),
                                        camera("right", at(-beside_m), off(5.0, 0.1, seed + 1000))};
      tell(cameras);
      EXPECT_THAT(cameras[0].reasons, IsEmpty()) << beside_m << " m, seed " << seed;
    }
  }
}

TEST(CameraMixups, AreNotWhereOneCameraMovedOrBothDid) {
  std::vector<SensorResult> cameras{camera("left", at(0.06)), camera("right", at(-0.06))};
  cameras[0].T_base_sensor = at(-0.06);
  tell(cameras);
  EXPECT_THAT(cameras[0].reasons, IsEmpty()) << "right stands where it should";
  cameras = {camera("left", at(0.06)), camera("right", at(-0.06))};
  cameras[0].T_base_sensor = at(0.56);
  cameras[1].T_base_sensor = at(0.44);
  tell(cameras);
  EXPECT_THAT(cameras[0].reasons, IsEmpty()) << "the bracket is another";
}

}  // namespace
}  // namespace rigcal
