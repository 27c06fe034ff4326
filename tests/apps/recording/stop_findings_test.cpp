#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/recording/cell_sink.h"
#include "apps/recording/far_points.h"
#include "apps/recording/rig_lidars.h"
#include "apps/recording/stop_reader.h"

namespace rigcal {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::uint64_t& dropped(StopReading& reading, DropReason reason) {
  return reading.points.dropped[static_cast<std::size_t>(reason)];
}

Rig two_lidars() {
  Rig rig;
  for (const char* name : {"near", "far"}) {
    rig.sensors.emplace_back();
    rig.sensors.back().name = name;
    rig.sensors.back().lidar.emplace();
  }
  return rig;
}

TEST(ReadingWarnings, TellOfPointsThatCameTooDenselyOrTooLate) {
  StopReading reading;
  reading.points.in_stops = 1'000'000;
  EXPECT_THAT(reading_warnings({}, reading), IsEmpty());
  dropped(reading, DropReason::overflow) = 17;
  dropped(reading, DropReason::late) = 500;
  EXPECT_THAT(reading_warnings({}, reading), ElementsAre(HasSubstr("17 points came too densely to be held")))
      << "a packet or two that come late are nobody's fault";
  dropped(reading, DropReason::late) = 2'000;
  EXPECT_THAT(reading_warnings({}, reading),
              ElementsAre(HasSubstr("17 points"), HasSubstr("2000 points came when their stop was long over")));
}

// What a table that turns on by more than 0.1 degrees a second makes of a recording.
TEST(ReadingWarnings, DoubtTheStopsOfAGyroThatNoLidarEverSees) {
  StopReading reading;
  reading.points.in_stops = 1'000'000;
  reading.view.points = 1'000'000;
  StopRecord stop;
  stop.stop = {0, 0, 8'000'000'000};
  reading.stops.push_back(stop);
  EXPECT_THAT(reading_warnings({}, reading), ElementsAre(HasSubstr("no LiDAR ever sees the rig at rest")));

  StopReading seen = reading;
  seen.view.stops = 1;
  EXPECT_THAT(reading_warnings({}, seen), IsEmpty());
  StopReading blind = reading;
  blind.view.blind_s = 7.0;
  EXPECT_THAT(reading_warnings({}, blind), IsEmpty()) << "who sees no surfaces sees no rest";
  StopReading brief = reading;
  brief.stops[0].stop.end_ns = 600'000'000;
  EXPECT_THAT(reading_warnings({}, brief), IsEmpty()) << "the points need longer than the gyro";
  StopReading unseen = reading;
  unseen.view.points = 0;
  EXPECT_THAT(reading_warnings({}, unseen), IsEmpty());
}

TEST(ReadingError, TellsARigThatTremblesFromOneThatRestsTooBriefly) {
  StopReading reading;
  reading.gyro.brief_rests = 4;
  reading.gyro.longest_brief_rest_s = 1.2;
  EXPECT_THAT(reading_error({}, {}, reading)->message(),
              AllOf(HasSubstr("4 pauses between turns, of about 1.2 s at most, were too short for a stop"),
                    HasSubstr("rest for two seconds and more")));
  reading.gyro.longest_brief_rest_s = 4.3;
  EXPECT_THAT(reading_error({}, {}, reading)->message(),
              AllOf(HasSubstr("of about 4.3 s at most, were no stop, though long enough: the rig seems to tremble"),
                    HasSubstr("switch off what shakes the rig"), Not(HasSubstr("too short for a stop")),
                    Not(HasSubstr("two seconds"))));
  StopRecord stop;
  stop.stop = {0, 0, 8'000'000'000};
  reading.stops.push_back(stop);
  reading.gyro.brief_rests = 1;
  EXPECT_THAT(reading_warnings({}, reading),
              ElementsAre(AllOf(HasSubstr("1 pause between turns, of about 4.3 s at most, was no stop"),
                                HasSubstr("switch off what shakes the rig"))));
}

TEST(NoPointsError, SaysWhatBecameOfThem) {
  StreamSource source;
  source.path = "run.bag";
  StopReading reading;
  EXPECT_THAT(no_points_error(source, reading, 0).message(), HasSubstr("check that sampling was on"));
  dropped(reading, DropReason::overflow) = 9'000'000;
  EXPECT_THAT(no_points_error(source, reading, 0).message(), HasSubstr("9000000 points came too densely"));
  EXPECT_THAT(no_points_error(source, reading, 5).message(),
              AllOf(HasSubstr("all points in the range of their LiDAR"), HasSubstr("farther than 60 m"),
                    HasSubstr("9000000 points came too densely")));
}

TEST(FarPoints, AreCountedWhereNoCellIsMadeOfThem) {
  const Rig rig = two_lidars();
  LidarRecording recording;
  recording.lidar_sensors = lidar_sensors(rig);  // By their names: "far" is the first.
  CellSink sink(rig, CellOptions{}, [&](CalibrationStop stop) { append(std::move(stop), recording); }, {});
  ASSERT_TRUE(sink.restart());
  for (int stop = 0; stop < 3; ++stop) {
    const Point near{2.0F, 1.0F, 0.0F, 0, 0, 0};
    const Point far{80.0F, 1.0F, 0.0F, 0, 0, 0};
    sink.points(0, stop, std::vector{near, near, far});
    sink.points(1, stop, std::vector{far, far});
    StopRecord record;
    record.stop.index = stop;
    sink.stop_done(record);
  }
  EXPECT_EQ(recording.too_far_of(0), 6U);
  EXPECT_EQ(recording.too_far_of(1), 3U);
  EXPECT_EQ(recording.patches.size(), 3U);
  EXPECT_THAT(far_point_warnings(rig, recording),
              ElementsAre("far: 6 of its 6 points in the stops lie farther than 60 m, where none are used; let it see "
                          "nearer surfaces"));
}

}  // namespace
}  // namespace rigcal
