#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/camera/camera.h"

namespace rigcal::camera {
namespace {

using testing::HasSubstr;

const std::vector<CameraIdentity> two{
    {"Hikrobot-MV-CA013-21UC-00F12345678", "192.168.1.40", "00F12345678", "Hikrobot", "MV-CA013-21UC", "GigE Vision"},
    {"Basler-acA1300-21", "192.168.1.41", "21", "Basler", "acA1300", "GigE Vision"}};

TEST(CameraLookup, TakesEachNameOfACamera) {
  for (const char* name : {"Basler-acA1300-21", "192.168.1.41", "21"}) {
    const auto found = find_camera(two, name);
    ASSERT_TRUE(found.has_value()) << name;
    EXPECT_EQ(found->vendor, "Basler");
  }
}

TEST(CameraLookup, NamesThoseThatAreThere) {
  const auto none = find_camera(two, "00F99999999");
  ASSERT_FALSE(none.has_value());
  EXPECT_EQ(none.error().kind, ErrorKind::system);
  EXPECT_THAT(none.error().message(), HasSubstr("there are Hikrobot-MV-CA013-21UC-00F12345678 at 192.168.1.40 and "
                                                "Basler-acA1300-21 at 192.168.1.41"));
  EXPECT_THAT(find_camera({}, "21").error().message(), HasSubstr("cable"));
  EXPECT_FALSE(find_camera(two, "").has_value());
}

TEST(CameraLookup, TwoWithOneNameAreToldApartByTheirAddress) {
  std::vector<CameraIdentity> twins = two;
  twins[1].serial = twins[0].serial;
  const auto found = find_camera(twins, twins[0].serial);
  ASSERT_FALSE(found.has_value());
  EXPECT_THAT(found.error().message(), HasSubstr("192.168.1.40"));
  EXPECT_THAT(found.error().message(), HasSubstr("192.168.1.41"));
}

TEST(CameraLookup, ListsWordsAsPeopleDo) {
  EXPECT_EQ(list_text({}), "none");
  EXPECT_EQ(list_text({"a"}), "a");
  EXPECT_EQ(list_text({"a", "b"}), "a and b");
  EXPECT_EQ(list_text({"a", "b", "c"}), "a, b and c");
}

}  // namespace
}  // namespace rigcal::camera
