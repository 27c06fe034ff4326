#include "simdata/gige/exposure_schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "simdata/gige/features.h"

namespace rigcal::sim {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::int64_t ms = 1'000'000;

std::vector<std::int64_t> starts_until(ExposureSchedule& schedule, std::int64_t end_ns) {
  std::vector<std::int64_t> starts;
  while (schedule.deadline_ns() <= end_ns) {
    const std::int64_t now = schedule.deadline_ns();
    while (const auto exposure = schedule.take(now)) starts.push_back(exposure->start_ns / ms);
  }
  return starts;
}

ExposureRules triggered(std::uint32_t source = 0) {
  ExposureRules rules;
  rules.is_triggered = true;
  rules.source = source;
  rules.exposure_ns = 5 * ms;
  rules.shortest_period_ns = 10 * ms;
  return rules;
}

TEST(ExposureSchedule, FreeRunningExposesAtItsRate) {
  ExposureRules rules;
  rules.exposure_ns = 5 * ms;
  rules.period_ns = 20 * ms;
  ExposureSchedule schedule;
  schedule.start(100 * ms, rules, 0);
  EXPECT_FALSE(schedule.take(104 * ms).has_value());  // It has not ended yet.
  EXPECT_THAT(starts_until(schedule, 166 * ms), ElementsAre(100, 120, 140, 160));
  schedule.stop();
  EXPECT_THAT(starts_until(schedule, 300 * ms), IsEmpty());
}

TEST(ExposureSchedule, NoExposureBeginsBeforeTheLastOneIsRead) {
  ExposureRules rules;
  rules.exposure_ns = 5 * ms;
  rules.period_ns = 6 * ms;
  rules.shortest_period_ns = 11 * ms;
  ExposureSchedule schedule;
  schedule.start(0, rules, 0);
  EXPECT_THAT(starts_until(schedule, 40 * ms), ElementsAre(0, 11, 22, 33));
}

TEST(ExposureSchedule, StopsByItselfAfterItsFrames) {
  ExposureRules rules;
  rules.period_ns = 20 * ms;
  ExposureSchedule schedule;
  schedule.start(0, rules, 3);
  EXPECT_THAT(starts_until(schedule, 1000 * ms), ElementsAre(0, 20, 40));
  EXPECT_FALSE(schedule.is_running());
}

TEST(ExposureSchedule, EachPulseIsOneExposureAfterTheDelay) {
  ExposureRules rules = triggered();
  rules.delay_ns = 3 * ms;
  ExposureSchedule schedule;
  schedule.start(0, rules, 0);
  EXPECT_EQ(schedule.deadline_ns(), INT64_MAX);
  for (int i = 0; i < 4; ++i) schedule.pulse({0, (100 + 50 * i) * ms, (101 + 50 * i) * ms, 7 + i});
  EXPECT_EQ(schedule.deadline_ns(), 103 * ms);
  EXPECT_FALSE(schedule.take(107 * ms).has_value());
  const auto first = schedule.take(108 * ms);
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->start_ns, 103 * ms);
  EXPECT_EQ(first->end_ns, 108 * ms);
  EXPECT_EQ(first->pulse, 7);
  EXPECT_THAT(starts_until(schedule, 1000 * ms), ElementsAre(153, 203, 253));
}

TEST(ExposureSchedule, AFallingEdgeComesAtThePulsesEnd) {
  ExposureRules rules = triggered();
  rules.on_falling_edge = true;
  ExposureSchedule schedule;
  schedule.start(0, rules, 0);
  schedule.pulse({0, 100 * ms, 130 * ms, 0});
  EXPECT_THAT(starts_until(schedule, 1000 * ms), ElementsAre(130));
}

TEST(ExposureSchedule, OtherSourcesReleaseNothing) {
  ExposureSchedule schedule;
  schedule.start(0, triggered(2), 0);
  schedule.pulse({0, 100 * ms, 101 * ms, 0});
  schedule.software_trigger(200 * ms);
  EXPECT_THAT(starts_until(schedule, 1000 * ms), IsEmpty());
  schedule.pulse({2, 300 * ms, 301 * ms, 0});
  EXPECT_THAT(starts_until(schedule, 1000 * ms), ElementsAre(300));
  schedule.set_rules(400 * ms, triggered(kSoftwareTrigger));
  schedule.pulse({2, 500 * ms, 501 * ms, 0});
  schedule.software_trigger(600 * ms);
  EXPECT_THAT(starts_until(schedule, 1000 * ms), ElementsAre(600));
}

TEST(ExposureSchedule, APulseThatComesTooSoonIsIgnoredAndCounted) {
  ExposureSchedule schedule;
  schedule.start(0, triggered(), 0);
  for (const int time : {100, 103, 108, 110, 119, 120}) schedule.pulse({0, time * ms, (time + 1) * ms, time});
  EXPECT_THAT(starts_until(schedule, 1000 * ms), ElementsAre(100, 110, 120));
  EXPECT_EQ(schedule.ignored(), 3U);
}

TEST(ExposureSchedule, PulsesBeforeTheStartAndAfterTheStopAreNone) {
  ExposureSchedule schedule;
  schedule.pulse({0, 0, ms, 0});
  schedule.start(10 * ms, triggered(), 0);
  EXPECT_THAT(starts_until(schedule, 50 * ms), IsEmpty());
  schedule.pulse({0, 60 * ms, 61 * ms, 0});
  schedule.stop();
  schedule.start(70 * ms, triggered(), 0);
  EXPECT_THAT(starts_until(schedule, 100 * ms), IsEmpty());
}

TEST(ExposureSchedule, FreeRunningAgainItBeginsThen) {
  ExposureSchedule schedule;
  schedule.start(0, triggered(), 0);
  ExposureRules rules;
  rules.exposure_ns = 5 * ms;
  rules.period_ns = 20 * ms;
  schedule.set_rules(500 * ms, rules);
  EXPECT_THAT(starts_until(schedule, 530 * ms), ElementsAre(500, 520));
}

}  // namespace
}  // namespace rigcal::sim
