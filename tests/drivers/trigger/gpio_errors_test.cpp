#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

#include "drivers/trigger/gpio_chips.h"
#include "drivers/trigger/trigger.h"

namespace rigcal::trigger {
namespace {

using testing::HasSubstr;

std::string message(int refusal, const LineUse& use = {}) {
  const std::vector<GpioChip> chips{{"gpiochip0", "pinctrl-soc", 54, 0}, {"gpiochip1", "", 0, EACCES}};
  const Error error = line_error({"gpiochip0", 99}, "be driven", refusal, use, chips);
  EXPECT_EQ(error.kind, ErrorKind::system);
  EXPECT_FALSE(error.mend.empty());
  EXPECT_THAT(error.message(), HasSubstr("gpiochip0, line 99: "));
  return error.message();
}

TEST(GpioErrors, NameTheCauseAndTheMend) {
  EXPECT_THAT(message(ENOENT), HasSubstr("there are: gpiochip0 (pinctrl-soc), gpiochip1"));
  EXPECT_THAT(message(EACCES), HasSubstr("sudo adduser $USER plugdev"));
  EXPECT_THAT(message(EBUSY, {true, "blinker"}), HasSubstr("held by blinker"));
  EXPECT_THAT(message(EBUSY), HasSubstr("held by another program"));
  EXPECT_THAT(message(EINVAL), HasSubstr("no such line, only 0 to 53"));
  EXPECT_THAT(message(ENODEV), HasSubstr("the GPIO chip is gone"));
  EXPECT_THAT(message(EOPNOTSUPP), HasSubstr("no interrupts"));
  EXPECT_THAT(message(ENOMEM), HasSubstr("Cannot allocate memory"));
}

TEST(GpioErrors, AreTheSameWhereThereIsNoChip) {
  const auto output = OutputLine::request({"gpiochip_that_is_not", 3}, "rigcal");
  ASSERT_FALSE(output.has_value());
  EXPECT_THAT(output.error().message(), HasSubstr("there is no such GPIO chip"));
  const auto input = InputLine::request({"/dev/gpiochip_that_is_not", 3}, "rigcal");
  ASSERT_FALSE(input.has_value());
  EXPECT_EQ(input.error().kind, ErrorKind::system);
  EXPECT_FALSE(line_use({"gpiochip_that_is_not", 3}).has_value());
}

TEST(Trigger, DoesNotStartWhereSomethingIsMissing) {
  TriggerOptions options;
  options.output = LineAddress{"gpiochip_that_is_not", 3};
  EXPECT_EQ(Trigger::start(options, net::read_clocks()).error().kind, ErrorKind::system);
  options.pattern.width_ns = options.pattern.period_ns;
  EXPECT_EQ(Trigger::start(options, net::read_clocks()).error().kind, ErrorKind::input);
  options.output.reset();
  options.pps = "pps_that_is_not";
  EXPECT_EQ(Trigger::start(options, net::read_clocks()).error().kind, ErrorKind::system);
}

TEST(Trigger, TellsTheClockOfAnEdgeByItsStamp) {
  const net::ClockReading now{1'700'000'000'000'000'000, 5'000'000'000'000};
  EXPECT_EQ(monotonic_of_edge(4'999'000'000'000, now), 4'999'000'000'000);
  EXPECT_EQ(monotonic_of_edge(1'699'999'999'000'000'000, now), 4'999'000'000'000);
}

}  // namespace
}  // namespace rigcal::trigger
