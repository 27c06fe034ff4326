#include "apps/recording/recorded_formats.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/noting_reporter.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(IsMisread, WhereAPngDoesNotTellWhatTheRigFileDoesNotSay) {
  EXPECT_TRUE(is_misread("BayerRG8", ""));
  EXPECT_TRUE(is_misread("BayerRG8", "BayerBG8"));
  EXPECT_TRUE(is_misread("Mono8", "BayerRG8"));
  EXPECT_FALSE(is_misread("BayerRG12", "BayerRG12"));
  EXPECT_FALSE(is_misread("BayerRG16", "BayerRG12")) << "16 are stored, and the rig file knows which count";
  EXPECT_FALSE(is_misread("Mono8", ""));
  EXPECT_FALSE(is_misread("Mono12", "")) << "how many of 16 bits count is seen from the images";
  EXPECT_FALSE(is_misread("RGB8", "")) << "a PNG has colours";
  EXPECT_FALSE(is_misread("", "BayerRG8")) << "never set up";
}

TEST(NameFormats, GoIntoTheSessionsRigFile) {
  const auto rig = parse_rig(
      "rigcal: 1\nname: lab\nbase: avia\nsensors:\n  avia: {type: livox_avia}\n  left: {type: camera}\n"
      "  right: {type: camera}\n",
      "lab.yaml");
  ASSERT_TRUE(rig) << rig.error().message();
  const std::filesystem::path session = scratch_folder("recorded_formats");
  NotingReporter reporter;
  ASSERT_TRUE(name_formats(session.string(), *rig, {}, reporter));
  EXPECT_FALSE(std::filesystem::exists(session / "rig.yaml"));
  ASSERT_TRUE(name_formats(session.string(), *rig, {{rig->find("right"), "BayerGR12"}}, reporter));
  const auto named = load_rig((session / "rig.yaml").string());
  ASSERT_TRUE(named) << named.error().message();
  EXPECT_EQ(named->sensors[static_cast<std::size_t>(named->find("right"))].camera->pixel_format, "BayerGR12");
  EXPECT_EQ(named->sensors[static_cast<std::size_t>(named->find("left"))].camera->pixel_format, "");
  EXPECT_THAT(reporter.warnings, ElementsAre(HasSubstr("right: its images are BayerGR12")));
}

}  // namespace
}  // namespace rigcal
