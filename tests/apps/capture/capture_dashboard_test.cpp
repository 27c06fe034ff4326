#include "apps/capture/capture_dashboard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/capture/capture_text.h"

namespace rigcal {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

CaptureStatus at_the_third_stop() {
  CaptureStatus status;
  status.seconds = 31.0;
  status.bytes = 250'000'000;
  status.progress.state = CaptureState::capturing;
  status.progress.stop = 3;
  status.progress.stops = 2;
  status.progress.wanted_stops = 20;
  status.progress.short_stops = 1;
  status.progress.dwell_s = 2.0;
  status.progress.rested_s = 1.0;
  status.table_deg = 36.0;
  status.disk = DiskRoom{12'300'000'000, 9.1e6, 1350.0};
  status.worst_wait_s = 0.0213;
  status.worst_write_s = 0.003;
  status.events = 6;
  for (int i = 0; i < 6; ++i) status.news.push_back("event " + std::to_string(i));
  return status;
}

TEST(CaptureDashboard, ShowsWhatToDoAndHowFarItIs) {
  const auto lines = dashboard_lines(at_the_third_stop());
  EXPECT_EQ(lines[0], "capturing | hold still: stop 3, 50 %");
  EXPECT_EQ(lines[1], "[############            ] 2 of 20 stops, 1 left early, table at 36.00 deg");
  EXPECT_EQ(lines[2], "captured 31 s, 250.0 MB");
  EXPECT_THAT(lines, Contains("disk: 12.3 GB free, 9.1 MB/s, full in 23 min"));
  EXPECT_THAT(lines, Contains("delays: a packet 21 ms at most, a write 3 ms at most"));
  EXPECT_EQ(lines.back(), "event 5");
  EXPECT_THAT(lines, Contains("event 2"));
  EXPECT_THAT(lines, testing::Not(Contains("event 1")));
  for (const std::string& line : lines) EXPECT_LE(line.size(), 79U);
}

TEST(CaptureDashboard, CountsOneStop) {
  CaptureStatus status = at_the_third_stop();
  status.progress.wanted_stops = status.progress.short_stops = 0;
  status.progress.stops = 1;
  status.table_deg.reset();
  EXPECT_EQ(dashboard_lines(status)[1], "[############            ] 1 stop");
}

// A small window leaves out the end.
TEST(CaptureDashboard, WhatCalibrationSaysComesBeforeWhatHappenedLast) {
  const auto lines = dashboard_lines(at_the_third_stop(), {"calibration:", "  turn by 30 degrees"});
  ASSERT_GE(lines.size(), 6U);
  EXPECT_EQ(lines[lines.size() - 6], "calibration:");
  EXPECT_EQ(lines[lines.size() - 5], "  turn by 30 degrees");
  EXPECT_EQ(lines.back(), "event 5");
}

TEST(CaptureDashboard, ThreadsThatDoNotMoveAreNamed) {
  CaptureStatus status = at_the_third_stop();
  EXPECT_THAT(dashboard_lines(status), testing::Not(Contains(StartsWith("not moving"))));
  status.stuck_threads = {"packets"};
  EXPECT_THAT(dashboard_lines(status), Contains("not moving: packets"));
}

TEST(CaptureDashboard, NewLinesAreToldOnce) {
  CaptureStatus status = at_the_third_stop();
  EXPECT_THAT(new_lines(status, 4), ElementsAre("event 4", "event 5"));
  EXPECT_THAT(new_lines(status, 6), IsEmpty());
  EXPECT_THAT(new_lines(status, 9), IsEmpty());
  status.events = 1000;  // More than it holds.
  EXPECT_EQ(new_lines(status, 6).size(), 6U);
}

}  // namespace
}  // namespace rigcal
