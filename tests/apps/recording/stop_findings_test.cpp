#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/recording/stop_reader.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::uint64_t& dropped(StopReading& reading, DropReason reason) {
  return reading.points.dropped[static_cast<std::size_t>(reason)];
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

TEST(NoPointsError, SaysWhatBecameOfThem) {
  StreamSource source;
  source.path = "run.bag";
  StopReading reading;
  EXPECT_THAT(no_points_error(source, reading).message(), HasSubstr("check that sampling was on"));
  dropped(reading, DropReason::overflow) = 9'000'000;
  EXPECT_THAT(no_points_error(source, reading).message(), HasSubstr("9000000 points came too densely"));
}

}  // namespace
}  // namespace rigcal
