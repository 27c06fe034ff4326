#include "apps/recording/stamp_guess.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::int64_t second_ns = 1'000'000'000;
constexpr std::int64_t begin_ns = 1'700'000'000 * second_ns;

// Stops of 2 s with turns of unequal length between them.
std::vector<Stop> stops_of(int count) {
  std::vector<Stop> stops;
  std::int64_t at_ns = begin_ns;
  for (int k = 0; k < count; ++k) {
    stops.push_back({k, at_ns, at_ns + 2 * second_ns});
    at_ns += (6 + k % 3) * second_ns;
  }
  return stops;
}

// One image in the middle of each stop.
std::vector<std::int64_t> stamps_of(const std::vector<Stop>& stops, std::int64_t late_ns, std::int64_t unit_ns) {
  std::vector<std::int64_t> stamps;
  for (const Stop& stop : stops) stamps.push_back((stop.start_ns + second_ns + late_ns) / unit_ns);
  return stamps;
}

TEST(GuessOfStamps, NamesTheUnit) {
  const std::vector<Stop> stops = stops_of(8);
  EXPECT_THAT(guess_of_stamps(stamps_of(stops, 0, 1000), stops), HasSubstr("look like microseconds: write nanosec"));
  EXPECT_THAT(guess_of_stamps(stamps_of(stops, 0, 1'000'000), stops), HasSubstr("milliseconds"));
  EXPECT_THAT(guess_of_stamps(stamps_of(stops, 0, second_ns), stops), HasSubstr("look like seconds"));
}

TEST(GuessOfStamps, NamesTheOffset) {
  const std::vector<Stop> stops = stops_of(8);
  EXPECT_THAT(guess_of_stamps(stamps_of(stops, 7200 * second_ns, 1), stops),
              HasSubstr("with -7200.000 s added to their stamps all would lie in stops (another time zone or clock?)"));
  EXPECT_THAT(guess_of_stamps(stamps_of(stops, -37 * second_ns, 1), stops), HasSubstr("with 37.000 s added"));
  // Of a device that counts from when it was switched on: known to half of a stop.
  EXPECT_THAT(guess_of_stamps(stamps_of(stops, -begin_ns + 5 * second_ns, 1), stops),
              HasSubstr("with 1699999995.000 s added"));
}

TEST(GuessOfStamps, SaysNothingThatItCannotKnow) {
  const std::vector<Stop> two = stops_of(2);
  EXPECT_THAT(guess_of_stamps(stamps_of(two, 1234 * second_ns, 1), two), IsEmpty()) << "some offset always fits two";
  EXPECT_THAT(guess_of_stamps(stamps_of(two, 3600 * second_ns, 1), two), HasSubstr("with -3600.000 s"));
  const std::vector<Stop> stops = stops_of(8);
  std::vector<std::int64_t> stamps = stamps_of(stops, 1234 * second_ns, 1);
  stamps[3] += 3 * second_ns;
  EXPECT_THAT(guess_of_stamps(stamps, stops), IsEmpty());
  EXPECT_THAT(guess_of_stamps({}, stops), IsEmpty());
  EXPECT_THAT(guess_of_stamps({0, std::numeric_limits<std::int64_t>::max()}, stops), IsEmpty());
}

}  // namespace
}  // namespace rigcal
