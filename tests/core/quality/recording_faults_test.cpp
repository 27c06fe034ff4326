#include "core/quality/recording_faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::string> texts(const PacketCounters& packets, const std::vector<ClockReport>& clocks) {
  std::vector<std::string> out;
  for (const RecordingFault& fault : recording_faults(packets, clocks)) out.push_back(to_string(fault));
  return out;
}

std::map<std::string, std::uint64_t> stream(const std::string& name, std::uint64_t expected, std::uint64_t lost,
                                            std::uint64_t gaps, std::uint64_t longest_gap_ms) {
  return {{name + "_expected", expected},
          {name + "_lost", lost},
          {name + "_gaps", gaps},
          {name + "_longest_gap_ms", longest_gap_ms}};
}

ClockReport sound(const std::string& sensor) { return {sensor, 40.0, 60.0, 20'000.0, 0, 0}; }

TEST(RecordingFaults, OfASoundRecordingAreNone) {
  EXPECT_THAT(texts({}, {}), IsEmpty());
  EXPECT_THAT(texts({{"left", stream("point", 100'000, 99, 99, 2)}, {"right", {}}}, {sound("left")}), IsEmpty());
}

TEST(RecordingFaults, SayHowMuchIsLostAndInHowManyPieces) {
  const std::string mend = "; check cable and switch, and the receive buffer (rigcal doctor)";
  EXPECT_THAT(texts({{"left", stream("point", 20'000, 620, 600, 4)}}, {}),
              ElementsAre("left: 3.1 % of its point packets are lost (620 in 600 gaps)" + mend));
  // A single long gap in a long recording is a small share.
  EXPECT_THAT(texts({{"left", stream("point", 10'000'000, 3000, 1, 3000)}}, {}),
              ElementsAre("left: 0.03 % of its point packets are lost (3000 in 1 gap, the longest 3.0 s)" + mend));
  std::map<std::string, std::uint64_t> both = stream("point", 1000, 170, 2, 150);
  both.merge(stream("imu", 1000, 2, 2, 10));
  EXPECT_THAT(texts({{"avia", both}}, {}),
              ElementsAre("avia: 17 % of its point packets are lost (170 in 2 gaps, the longest 0.1 s), 0.20 % of its "
                          "IMU packets are lost (2 in 2 gaps)" +
                          mend));
}

TEST(RecordingFaults, SayWhatIsWrongWithAClock) {
  ClockReport clock = sound("left");
  clock.jumps = 7;
  EXPECT_THAT(texts({}, {clock}), ElementsAre("left: its clock jumped 7 times: it was set, or the device started anew; "
                                              "check its power and what sets its clock (PTP, GPS)"));
  clock = sound("left");
  clock.drift_ppm = -499.8;
  EXPECT_THAT(
      texts({}, {clock}),
      ElementsAre("left: its clock runs slow by 500 ppm or more, as no sound one does: its points are placed by "
                  "when its packets came; have the device checked"));
  clock.drift_ppm = 250.0;
  EXPECT_THAT(texts({}, {clock}), ElementsAre(testing::HasSubstr("runs fast by 250 ppm, as no sound one does")));
  clock = sound("left");
  clock.strays = 1;
  clock.max_delay_us = 350'000.0;
  EXPECT_THAT(texts({}, {clock}),
              ElementsAre("left: 1 packet has a senseless time stamp and was left out; check its cable",
                          "left: packets of it came up to 0.35 s late; check what else the network and the recording "
                          "machine had to do"));
}

TEST(RecordingFaults, StandByTheNameOfTheSensorLossesFirst) {
  ClockReport jumping = sound("left");
  jumping.jumps = 1;
  ClockReport other = sound("avia");
  other.jumps = 2;
  std::vector<std::string> order;
  const auto faults = recording_faults({{"left", stream("point", 100, 50, 1, 2)}}, {jumping, other});
  for (const RecordingFault& fault : faults) order.push_back(fault.sensor + " " + fault.what.substr(0, 9));
  EXPECT_THAT(order, ElementsAre("avia its clock", "left 50 % of i", "left its clock"));
  EXPECT_EQ(faults_in_brief(faults), "packets lost (left); clock (avia, left)");
  EXPECT_EQ(faults_in_brief({}), "");
}

}  // namespace
}  // namespace rigcal
