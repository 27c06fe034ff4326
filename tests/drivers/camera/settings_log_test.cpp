#include "drivers/camera/aravis/settings_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/scratch_folder.h"

namespace rigcal::camera {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const OldSetting width{"", "", "Width", "1280"};
const OldSetting mode{"TriggerSelector", "FrameStart", "TriggerMode", "Off"};

class SettingsLogFile : public testing::Test {
 protected:
  void spoil(const std::string& text) {
    std::filesystem::create_directories(std::filesystem::path(file).parent_path());
    std::ofstream(file) << text;
  }
  std::filesystem::path scratch = scratch_folder("settings_log");
  std::string file = settings_file((scratch / "cameras").string(), "Hikrobot-MV-00F1");
};

TEST_F(SettingsLogFile, IsThereFromTheFirstChangeToTheEnd) {
  SettingsLog log(file);
  EXPECT_FALSE(std::filesystem::exists(file));
  log.add(width);
  EXPECT_THAT(*SettingsLog::read_left(file), ElementsAre(width));
  log.add(mode);
  // As a program finds it that comes after a crash: nobody has closed the file.
  EXPECT_THAT(*SettingsLog::read_left(file), ElementsAre(width, mode));
  EXPECT_THAT(log.settings(), ElementsAre(width, mode));
  log.clear();
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_THAT(*SettingsLog::read_left(file), IsEmpty());
}

TEST_F(SettingsLogFile, StaysWhereNobodyPutsTheSettingsBack) {
  { SettingsLog(file).add(width); }
  EXPECT_THAT(*SettingsLog::read_left(file), ElementsAre(width));
}

TEST_F(SettingsLogFile, ALineThatWasCutShortIsLeftOut) {
  const std::string whole = "selector,entry,feature,value\n,,Width,1280\nTriggerSelector,FrameStart,TriggerMode,Off\n";
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    spoil(whole.substr(0, size));
    const auto left = SettingsLog::read_left(file);
    ASSERT_TRUE(left.has_value()) << size << ": " << left.error().message();
    for (std::size_t i = 0; i < left->size(); ++i) EXPECT_EQ((*left)[i], i == 0 ? width : mode);
    EXPECT_EQ(left->size(), size < 42 ? 0U : size < whole.size() ? 1U : 2U) << size;
  }
}

TEST_F(SettingsLogFile, WhatIsNoSuchTableIsAnError) {
  for (const char* text : {"something else\n", "selector,entry,feature,value\nWidth,1280\n", "\n\n,,,\n"}) {
    spoil(text);
    EXPECT_FALSE(SettingsLog::read_left(file).has_value()) << text;
  }
}

TEST_F(SettingsLogFile, AFolderThatCannotBeMadeIsSaidOnce) {
  std::ofstream(scratch / "cameras") << "in the way";
  SettingsLog log(file);
  log.add(width);
  log.add(mode);
  ASSERT_TRUE(log.trouble().has_value());
  EXPECT_THAT(log.settings(), ElementsAre(width, mode));
}

TEST(SettingsFile, IsNamedAfterTheCamera) {
  EXPECT_EQ(settings_file("/state", "Hikrobot-MV-CA013-21UC-00F1"), "/state/Hikrobot-MV-CA013-21UC-00F1.csv");
  EXPECT_EQ(settings_file("/state", "../../etc/passwd x"), "/state/______etc_passwd_x.csv");
  EXPECT_EQ(settings_file("", "Hikrobot"), "");
}

}  // namespace
}  // namespace rigcal::camera
