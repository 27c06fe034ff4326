#include "core/io/frame_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

const std::string header = "file,stamp_ns,trigger,exposure_us,device_stamp,stop\n";

TEST(FrameFiles, TellWhereTheFirstLineThatIsWrongBegins) {
  const auto good = [](const std::string& lines) {
    std::size_t bytes = 99;
    static_cast<void>(parse_turntable("stamp_ns,angle_deg\n" + lines, "t", &bytes));
    return bytes - 19;
  };
  EXPECT_EQ(good("5,0\n7,1\n"), 8U);
  EXPECT_EQ(good("5,0\n7,x\n9,1\n"), 4U);
  EXPECT_EQ(good("5,0\n\n7\n9,1\n"), 5U);
  EXPECT_EQ(good("5,0\n5,0\n7\n"), 4U) << "the first, not the one with too few values";
  EXPECT_THAT(parse_turntable("stamp_ns,angle_deg\n5,0\n5,0\n7\n", "t").error().message(), HasSubstr("t:3"));
  std::size_t bytes = 99;
  EXPECT_FALSE(parse_frames("file,stamp\n", "f", &bytes).has_value());
  EXPECT_EQ(bytes, 0U);
}

TEST(FrameFiles, ReadBackWhatWasWritten) {
  std::vector<FrameRecord> frames(2);
  frames[0] = {"000000.png", 1'700'000'000'123'456'789, 12, 5000.25, 987'654'321'000, 3};
  frames[1].file = "000001.png";
  frames[1].stamp_ns = 1'700'000'001'000'000'000;
  const std::string path = fresh_path("frames.csv");
  ASSERT_TRUE(write_frames(path, frames).has_value());
  const auto read = read_frames(path);
  ASSERT_TRUE(read.has_value()) << read.error().message();
  ASSERT_EQ(2U, read->size());
  EXPECT_EQ("000000.png", (*read)[0].file);
  EXPECT_EQ(frames[0].stamp_ns, (*read)[0].stamp_ns);
  EXPECT_EQ(12, (*read)[0].trigger);
  EXPECT_EQ(5000.25, (*read)[0].exposure_us);
  EXPECT_EQ(frames[0].device_stamp, (*read)[0].device_stamp);
  EXPECT_EQ(3, (*read)[0].stop);
  EXPECT_EQ(frames[1].stamp_ns, (*read)[1].stamp_ns);
  EXPECT_FALSE((*read)[1].trigger || (*read)[1].exposure_us || (*read)[1].device_stamp || (*read)[1].stop);

  const std::vector<TriggerPulse> pulses{{0, 5}, {1, 7}, {4, 1'700'000'000'000'000'000}};
  const std::string trigger = fresh_path("trigger.csv");
  ASSERT_TRUE(write_trigger(trigger, pulses).has_value());
  const auto stamps = read_trigger(trigger);
  ASSERT_TRUE(stamps.has_value());
  ASSERT_EQ(3U, stamps->size());
  EXPECT_EQ(4, (*stamps)[2].pulse);
  EXPECT_EQ(pulses[2].stamp_ns, (*stamps)[2].stamp_ns);
}

TEST(FrameFiles, TakeTheLineEndsOfWindowsAndEmptyLines) {
  const auto frames = parse_frames("file,stamp_ns,trigger,exposure_us,device_stamp,stop\r\n\r\na.png,5,,,,\r\n", "f");
  ASSERT_TRUE(frames.has_value()) << frames.error().message();
  EXPECT_EQ(1U, frames->size());
}

TEST(FrameFiles, NameTheLineThatIsWrong) {
  const auto refusal = [](const std::string& lines) {
    const auto frames = parse_frames(header + lines, "frames.csv");
    return frames ? "accepted" : frames.error().message();
  };
  EXPECT_THAT(refusal("a.png,1,,,,\nb.png,x,,,,\n"), HasSubstr("frames.csv:3: stamp_ns is 'x'"));
  EXPECT_THAT(refusal("a.png,1,,,\n"), HasSubstr("frames.csv:2: the line has not 6 values"));
  EXPECT_THAT(refusal("a.png,1,,,,,\n"), HasSubstr("6 values"));
  EXPECT_THAT(refusal("../a.png,1,,,,\n"), HasSubstr("not plain"));
  EXPECT_THAT(refusal(",1,,,,\n"), HasSubstr("not plain"));
  EXPECT_THAT(refusal("a.png,1,,,,\na.png,2,,,,\n"),
              HasSubstr("frames.csv:3: the file a.png stands here a second time"));
  EXPECT_THAT(refusal("a.png,1,-2,,,\n"), HasSubstr("trigger is '-2'"));
  EXPECT_THAT(refusal("a.png,1,,nan,,\n"), HasSubstr("exposure_us"));
  EXPECT_THAT(refusal("a.png,99999999999999999999,,,,\n"), HasSubstr("stamp_ns"));
  EXPECT_THAT(refusal("a.png,1,,,,1.5\n"), HasSubstr("stop"));
  EXPECT_THAT(parse_frames("a.png,1,,,,\n", "f").error().message(), HasSubstr("not the header"));
  EXPECT_THAT(parse_frames("", "f").error().message(), HasSubstr("is empty"));
  EXPECT_EQ(0U, parse_frames(header, "f")->size());
}

TEST(FrameFiles, ATableThatGrowsCanBeReadAtAnyTime) {
  const std::string path = fresh_path("frames.csv");
  auto table = FrameTable::create(path);
  ASSERT_TRUE(table.has_value()) << table.error().message();
  EXPECT_EQ(0U, read_frames(path)->size());
  FrameRecord frame;
  for (int i = 0; i < 3; ++i) {
    frame.file = std::to_string(i) + ".png";
    frame.stamp_ns = i;
    ASSERT_TRUE(table->add(frame).has_value());
    EXPECT_EQ(static_cast<std::size_t>(i + 1), read_frames(path)->size());
  }
  EXPECT_TRUE(table->close().has_value());
  EXPECT_FALSE(FrameTable::create("/no/such/folder/frames.csv").has_value());
}

TEST(FrameFiles, PulsesMustGoUp) {
  const auto refusal = [](const std::string& lines) {
    return parse_trigger("pulse,stamp_ns\n" + lines, "trigger.csv").error().message();
  };
  EXPECT_THAT(refusal("0,5\n0,6\n"), HasSubstr("trigger.csv:3"));
  EXPECT_THAT(refusal("0,5\n1,5\n"), HasSubstr("does not lie after"));
  EXPECT_THAT(refusal("0\n"), HasSubstr("2 values"));
}

TEST(FrameFiles, TableAnglesGoThereAndBack) {
  const std::string path = fresh_path("turntable.csv");
  auto table = TurntableTable::create(path);
  ASSERT_TRUE(table.has_value());
  ASSERT_TRUE(table->add({5, -12.25}).has_value());
  ASSERT_TRUE(table->add({1'700'000'000'000'000'000, 378.0}).has_value());
  const auto angles = read_turntable(path);  // While it is being written.
  ASSERT_TRUE(angles) << angles.error().message();
  ASSERT_EQ(angles->size(), 2U);
  EXPECT_EQ((*angles)[0].angle_deg, -12.25);
  EXPECT_EQ((*angles)[1].stamp_ns, 1'700'000'000'000'000'000);
  EXPECT_TRUE(table->close().has_value());
}

TEST(FrameFiles, TableAnglesThatMakeNoSenseAreRefused) {
  const auto refusal = [](const std::string& lines) {
    const auto angles = parse_turntable("stamp_ns,angle_deg\n" + lines, "turntable.csv");
    return angles ? std::string() : angles.error().message();
  };
  EXPECT_EQ(refusal(""), "");
  EXPECT_THAT(refusal("1,2\n1,3\n"), HasSubstr("turntable.csv:3"));
  EXPECT_THAT(refusal("1,nan\n"), HasSubstr("angle_deg is 'nan'"));
  EXPECT_THAT(refusal("1,1e9\n"), HasSubstr("angle_deg"));
  EXPECT_THAT(refusal("1\n"), HasSubstr("2 values"));
  EXPECT_THAT(parse_turntable("angle_deg,stamp_ns\n", "t").error().message(), HasSubstr("header"));
}

}  // namespace
}  // namespace rigcal
