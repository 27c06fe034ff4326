// The trigger on the kernel's own GPIO interface, with a simulated chip: in the virtual machine of tests/hil/run.
#include "tests/drivers/trigger/gpio_sim.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>

#include "drivers/trigger/trigger.h"

namespace rigcal::trigger {
namespace {

using testing::HasSubstr;

constexpr std::int64_t ms = 1'000'000;
constexpr unsigned out_line = 1;
constexpr unsigned in_line = 2;

class TriggerOnGpioSim : public testing::Test {
 protected:
  void SetUp() override {
    if (!GpioSim::is_available())
      GTEST_SKIP() << "SKIP: this kernel has no gpio-sim, or this is not root; tests/hil/run has one";
    chip = std::make_unique<GpioSim>("rigcal-test");
  }
  [[nodiscard]] std::unique_ptr<Trigger> start(std::int64_t period_ns, std::int64_t width_ns,
                                               std::uint64_t count) const {
    TriggerOptions options;
    options.output = LineAddress{"rigcal-test", out_line};
    options.strobe = LineAddress{"rigcal-test", in_line};
    options.pattern.period_ns = period_ns;
    options.pattern.width_ns = width_ns;
    options.pattern.count = count;
    options.realtime = true;
    auto trigger = Trigger::start(options, net::read_clocks());
    EXPECT_TRUE(trigger.has_value()) << (trigger ? "" : trigger.error().message());
    return trigger ? *std::move(trigger) : nullptr;
  }
  static std::optional<TriggerEvent> wait_for(Trigger& trigger, TriggerSource source, TriggerEventKind kind) {
    TriggerEvent event;
    for (int i = 0; i < 1000 && trigger.next(event, 5000 * ms); ++i)
      if (event.source == source && event.kind == kind) return event;
    return std::nullopt;
  }
  std::unique_ptr<GpioSim> chip;
};

TEST_F(TriggerOnGpioSim, SeesAThousandPulsesAgainAndNoneMore) {
  const SimulatedWire wire(*chip, out_line, in_line);
  const auto trigger = start(50 * ms, 25 * ms, 1000);
  ASSERT_NE(trigger, nullptr);
  std::map<std::int64_t, std::int64_t> given;
  std::map<std::int64_t, std::int64_t> seen;
  std::map<std::int64_t, std::int64_t> ended;
  std::size_t ends = 0;
  bool is_finished = false;
  TriggerEvent event;
  while (!is_finished && trigger->next(event, 5000 * ms)) {
    is_finished = event.kind == TriggerEventKind::finished;
    if (event.kind == TriggerEventKind::end) {
      if (event.source == TriggerSource::output) {
        ended[event.number] = event.stamp_ns;
      } else {
        ++ends;
      }
    }
    if (event.kind != TriggerEventKind::pulse) continue;
    (event.source == TriggerSource::output ? given : seen)[event.number] = event.stamp_ns;
  }
  while (trigger->next(event, 500 * ms)) {
    if (event.kind == TriggerEventKind::end) ++ends;
    if (event.kind == TriggerEventKind::pulse) seen[event.number] = event.stamp_ns;
  }
  trigger->stop();
  const TriggerReport report = trigger->report();
  std::printf("lateness of the pulses\n%sdelay on the way back\n%s", report.lateness.text().c_str(),
              report.strobe_delay.text().c_str());
  ASSERT_EQ(report.pulses, given.size());
  EXPECT_EQ(report.pulses, 1000U);
  ASSERT_EQ(ended.size(), given.size());
  // Where the machine stalls between a pulse and its stamp, it seems shorter than it was.
  const auto shorter = std::count_if(given.begin(), given.end(),
                                     [&](const auto& pulse) { return ended.at(pulse.first) - pulse.second < 24 * ms; });
  EXPECT_LE(shorter, 10);
  EXPECT_EQ(seen.size(), wire.passed()) << "all that the wire passed on are seen, and none more";
  EXPECT_EQ(ends, seen.size());
  EXPECT_EQ(report.strobe_lost, 0U);
  EXPECT_EQ(report.dropped_events, 0U);
  EXPECT_GE(wire.passed(), 990U) << "the wire is a loop that polls; this machine is too busy for it";
  EXPECT_LE(wire.passed(), report.pulses);
  std::printf("%llu pulses given, %llu passed on by the wire, %zu seen\n",
              static_cast<unsigned long long>(report.pulses), static_cast<unsigned long long>(wire.passed()),
              seen.size());
  EXPECT_FALSE(chip->is_high(out_line));
}

TEST_F(TriggerOnGpioSim, LeavesTheLineLowWhenItIsStoppedOrForgotten) {
  for (const bool is_stopped : {true, false}) {
    auto trigger = start(1000 * ms, 900 * ms, 0);
    ASSERT_NE(trigger, nullptr);
    ASSERT_TRUE(wait_for(*trigger, TriggerSource::output, TriggerEventKind::pulse).has_value());
    EXPECT_TRUE(chip->is_high(out_line));
    if (is_stopped) trigger->stop();
    trigger.reset();
    EXPECT_FALSE(chip->is_high(out_line));
  }
  auto line = OutputLine::request({chip->chip(), out_line}, "rigcal");
  ASSERT_TRUE(line.has_value());
  ASSERT_TRUE(line->set(true).has_value());
  try {
    const OutputLine taken = *std::move(line);
    throw std::runtime_error("something else went wrong");
  } catch (const std::runtime_error&) {
  }
  EXPECT_FALSE(chip->is_high(out_line));
}

TEST_F(TriggerOnGpioSim, SaysWhoHoldsALineAndWhatIsThere) {
  const auto held = OutputLine::request({chip->chip(), out_line}, "blinker");
  ASSERT_TRUE(held.has_value());
  EXPECT_EQ(line_use({chip->chip(), out_line})->consumer, "blinker");
  EXPECT_FALSE(line_use({chip->chip(), in_line})->is_used);
  EXPECT_THAT(OutputLine::request({chip->chip(), out_line}, "rigcal").error().message(), HasSubstr("held by blinker"));
  EXPECT_THAT(InputLine::request({chip->chip(), 99}, "rigcal").error().message(), HasSubstr("only 0 to 7"));
  EXPECT_THAT(InputLine::request({"gpiochip99", 0}, "rigcal").error().message(), HasSubstr("(rigcal-test)"));
  EXPECT_TRUE(OutputLine::request({"rigcal-test", 3}, "rigcal").has_value());  // By its label.
}

TEST_F(TriggerOnGpioSim, GoesOnWhenTheChipComesBack) {
  const auto trigger = start(50 * ms, 5 * ms, 0);
  ASSERT_NE(trigger, nullptr);
  ASSERT_TRUE(wait_for(*trigger, TriggerSource::output, TriggerEventKind::pulse).has_value());
  const auto unplugged = std::chrono::steady_clock::now();
  chip->unplug();
  const auto lost = wait_for(*trigger, TriggerSource::output, TriggerEventKind::lost);
  ASSERT_TRUE(lost.has_value());
  EXPECT_LT(std::chrono::steady_clock::now() - unplugged, std::chrono::seconds(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // The strobe's thread has noticed it, too.
  chip->plug_in();
  ASSERT_TRUE(wait_for(*trigger, TriggerSource::output, TriggerEventKind::returned).has_value());
  ASSERT_TRUE(wait_for(*trigger, TriggerSource::output, TriggerEventKind::pulse).has_value());
  trigger->stop();
  EXPECT_GT(trigger->report().skipped, 0U);
  EXPECT_EQ(trigger->report().losses, 2U);  // The output and the strobe line.
}

TEST_F(TriggerOnGpioSim, StampsEdgesWithTheTimeOfTheKernel) {
  TriggerOptions options;
  options.strobe = LineAddress{chip->chip(), in_line};
  const net::ClockReading start = net::read_clocks();
  const auto trigger = Trigger::start(options, start);
  ASSERT_TRUE(trigger.has_value());
  const net::SessionClock clock(start);
  for (int i = 0; i < 20; ++i) {
    const std::int64_t before = clock.from_monotonic(net::read_clocks().monotonic_ns);
    chip->pull(in_line, true);
    const std::int64_t after = clock.from_monotonic(net::read_clocks().monotonic_ns);
    const auto event = wait_for(**trigger, TriggerSource::strobe, TriggerEventKind::pulse);
    ASSERT_TRUE(event.has_value());
    EXPECT_EQ(event->number, i);
    EXPECT_GE(event->stamp_ns, before);
    EXPECT_LE(event->stamp_ns, after + 5 * ms);  // The simulator raises its interrupt a little later.
    chip->pull(in_line, false);
    ASSERT_TRUE(wait_for(**trigger, TriggerSource::strobe, TriggerEventKind::end).has_value());
  }
}

}  // namespace
}  // namespace rigcal::trigger
