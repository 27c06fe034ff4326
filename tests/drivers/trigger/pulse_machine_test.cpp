#include "drivers/trigger/pulse_machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "core/base/random.h"

namespace rigcal::trigger {
namespace {

using testing::HasSubstr;

constexpr std::int64_t us = 1000;
constexpr std::int64_t ms = 1000 * us;
constexpr std::int64_t start = 5'000 * ms;

struct Pulse {
  std::int64_t rose_ns = 0;
  std::int64_t fell_ns = 0;
};

/// What the line does when each wake-up comes late by what `late` says.
std::vector<Pulse> run(PulseMachine& machine, const std::function<std::int64_t()>& late) {
  std::vector<Pulse> pulses;
  bool is_high = false;
  std::int64_t now = start;
  while (const auto wake = machine.wake_ns()) {
    EXPECT_FALSE(machine.step(*wake - 1).has_value()) << "too early";
    now = std::max(now, *wake + late());
    const auto action = machine.step(now);
    if (!action) continue;  // Left out.
    EXPECT_NE(action->is_high, is_high);
    is_high = action->is_high;
    EXPECT_EQ(action->pulse, pulses.size() - (is_high ? 0 : 1));
    if (is_high) {
      pulses.push_back({now, 0});
    } else {
      pulses.back().fell_ns = now;
    }
  }
  EXPECT_FALSE(is_high) << "left high";
  return pulses;
}

PulsePattern pattern_of(std::uint64_t count) {
  PulsePattern pattern;
  pattern.count = count;
  return pattern;
}

TEST(PulseMachine, GivesNoneWhileItIsHeldAndGoesOnInThePattern) {
  PulseMachine machine(pattern_of(0), start);
  machine.hold(true);
  std::vector<std::int64_t> rises;
  for (std::int64_t now = start; now < start + 1000 * ms; now += ms) {
    machine.hold(now < start + 200 * ms || now >= start + 500 * ms + ms);  // Let go just after a pulse has begun.
    const auto action = machine.step(now);
    if (action && action->is_high) rises.push_back(now - start);
    if (action && !action->is_high) {
      EXPECT_EQ(now - start, rises.back() + ms) << "a pulse that was under way was cut";
    }
  }
  EXPECT_THAT(rises, testing::ElementsAre(200 * ms, 250 * ms, 300 * ms, 350 * ms, 400 * ms, 450 * ms, 500 * ms));
  EXPECT_EQ(machine.pulses(), 7U);
  EXPECT_EQ(machine.held(), 13U);
  EXPECT_EQ(machine.skipped(), 0U);
}

TEST(PulseMachine, GivesPulsesInTheirTimes) {
  PulseMachine machine(pattern_of(1000), start);
  const auto pulses = run(machine, [] { return 0; });
  ASSERT_EQ(pulses.size(), 1000U);
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    EXPECT_EQ(pulses[i].rose_ns, start + static_cast<std::int64_t>(i) * 50 * ms);
    EXPECT_EQ(pulses[i].fell_ns, pulses[i].rose_ns + ms);
  }
  EXPECT_EQ(machine.skipped(), 0U);
}

TEST(PulseMachine, GivesBursts) {
  PulsePattern pattern = pattern_of(7);
  pattern.period_ns = 10 * ms;
  pattern.burst = 3;
  pattern.burst_period_ns = 500 * ms;
  PulseMachine machine(pattern, start);
  std::vector<std::int64_t> rose;
  for (const Pulse& pulse : run(machine, [] { return 0; })) rose.push_back((pulse.rose_ns - start) / ms);
  EXPECT_THAT(rose, testing::ElementsAre(0, 10, 20, 500, 510, 520, 1000));
}

TEST(PulseMachine, KeepsToItsTimesAndWidthsWhereWakeUpsAreLate) {
  Random random(3);
  PulseMachine machine(pattern_of(2000), start);
  const auto pulses = run(machine, [&random] { return static_cast<std::int64_t>(random.below(5) * ms); });
  ASSERT_EQ(pulses.size(), 2000U);
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    const std::int64_t due = start + static_cast<std::int64_t>(i) * 50 * ms;
    EXPECT_GE(pulses[i].rose_ns, due);
    EXPECT_LE(pulses[i].rose_ns, due + 5 * ms);  // Lateness does not add up.
    EXPECT_GE(pulses[i].fell_ns - pulses[i].rose_ns, ms);
  }
}

TEST(PulseMachine, LeavesOutWhatIsTooLateAndNeverSqueezesPulses) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Random random(seed);
    PulseMachine machine(pattern_of(500), start);
    const auto pulses = run(
        machine, [&random] { return static_cast<std::int64_t>(random.below(20) == 0 ? random.below(400) * ms : 0); });
    EXPECT_EQ(pulses.size(), 500U);
    EXPECT_GT(machine.skipped(), 20U);
    for (std::size_t i = 1; i < pulses.size(); ++i)
      EXPECT_GE(pulses[i].rose_ns - pulses[i - 1].fell_ns, ms) << "the line was not low long enough";
  }
}

TEST(PulseMachine, EndsAPulseThatIsUnderWay) {
  PulseMachine machine(pattern_of(0), start);
  ASSERT_TRUE(machine.step(start)->is_high);
  machine.end();
  EXPECT_EQ(machine.wake_ns(), start + ms);
  const auto last = machine.step(start + ms);
  ASSERT_TRUE(last.has_value());
  EXPECT_FALSE(last->is_high);
  EXPECT_FALSE(machine.wake_ns().has_value());
  EXPECT_FALSE(machine.step(start + 100 * ms).has_value());
}

TEST(PulseMachine, EndsAtOnceWhereNoPulseIsUnderWay) {
  PulseMachine machine(pattern_of(0), start);
  machine.end();
  EXPECT_FALSE(machine.wake_ns().has_value());
}

TEST(PulsePatterns, ThatCannotBeAreRefusedInWords) {
  const auto message = [](const PulsePattern& pattern) {
    const auto checked = check_pattern(pattern);
    return checked ? std::string() : checked.error().message();
  };
  EXPECT_EQ(message({}), "");
  EXPECT_THAT(message({ms, ms, 0, 0, 0}), HasSubstr("1000 us every 1000 us leave no time"));
  EXPECT_THAT(message({50 * ms, 0, 0, 0, 0}), HasSubstr("less than 1 us"));
  EXPECT_THAT(message({50 * ms, ms, 0, 5, 200 * ms}), HasSubstr("bursts of 5 pulses"));
  EXPECT_EQ(message({50 * ms, ms, 0, 5, 250 * ms}), "");
  EXPECT_THAT(message({7'200'000 * ms, ms, 0, 0, 0}), HasSubstr("more than an hour"));
}

}  // namespace
}  // namespace rigcal::trigger
