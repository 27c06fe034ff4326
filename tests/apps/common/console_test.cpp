#include "apps/common/console.h"

#include <gtest/gtest.h>

#include <sstream>

#include "apps/common/exit_code.h"

namespace rigcal {
namespace {

using std::chrono::milliseconds;

class Console : public testing::Test {
 protected:
  std::ostringstream out;
  SteadyClock::time_point now{};
  ConsoleReporter reporter{out, [this] { return now; }};

  void pass(int ms) { now += milliseconds(ms); }
};

TEST_F(Console, PrintsPlainLinesSeldomWhereThereIsNoTerminal) {
  for (int i = 0; i <= 100; ++i) {
    pass(50);
    reporter.progress("joint solve", i / 100.0);
  }
  // 5.05 s at most a line every 2 s: two lines.
  EXPECT_EQ(out.str(), "rigcal: joint solve 39 %\nrigcal: joint solve 79 %\n");
}

TEST_F(Console, DrawsABarOverItselfOnATerminalAndTakesItAwayBeforeAWarning) {
  reporter.configure({.terminal = true});
  pass(100);
  reporter.progress("reading", 0.5);
  EXPECT_EQ(out.str(), "[###############               ] 50 % reading");
  out.str("");
  reporter.warn("a packet is damaged");
  EXPECT_EQ(out.str(), "\r" + std::string(45, ' ') + "\rrigcal: warning: a packet is damaged\n");
}

TEST_F(Console, DrawsABlockOverItselfOnATerminal) {
  reporter.configure({.terminal = true});
  reporter.block({"captured 1 s", std::string(100, 'x')});
  EXPECT_EQ(out.str(), "captured 1 s\n" + std::string(79, 'x') + "\n");
  out.str("");
  reporter.block({"captured 2 s"});
  EXPECT_EQ(out.str(), "\x1b[2A\x1b[Jcaptured 2 s\n");
  out.str("");
  reporter.warn("w");
  EXPECT_EQ(out.str(), "\x1b[1A\x1b[Jrigcal: warning: w\n");
}

// What wraps or scrolls out at the top could not be erased, and would be left there twice a second.
TEST_F(Console, DrawsOnlyWhatTheTerminalHasRoomFor) {
  TerminalSize size{20, 5};
  reporter.configure({.terminal = true, .size = [&] { return size; }});
  reporter.block({"captured 1 s", std::string(30, 'x'), "avia"});
  EXPECT_EQ(out.str(), "captured 1 s\n" + std::string(19, 'x') + "\navia\n");
  out.str("");
  size = {40, 4};
  reporter.block({"captured 2 s", "avia", "left", "right"});
  EXPECT_EQ(out.str(), "\x1b[3A\x1b[Jcaptured 2 s\n3 more lines: make the window higher\n");
  out.str("");
  size = {10, 3};
  pass(100);
  reporter.progress("reading", 0.5);
  EXPECT_EQ(out.str(), "\x1b[2A\x1b[J[########");
}

TEST_F(Console, PrintsABlockSeldomWhereThereIsNoTerminal) {
  for (int i = 1; i <= 11; ++i) {
    pass(1000);
    reporter.block({"captured " + std::to_string(i) + " s", "avia"});
  }
  EXPECT_EQ(out.str(), "rigcal: captured 5 s\nrigcal: avia\nrigcal: captured 10 s\nrigcal: avia\n");
}

TEST_F(Console, SaysNothingOfProgressWhenQuietButStillWarns) {
  reporter.configure({.quiet = true});
  pass(10000);
  reporter.progress("reading", 0.5);
  EXPECT_EQ(out.str(), "");
  reporter.warn("w");
  EXPECT_EQ(out.str(), "rigcal: warning: w\n");
}

TEST_F(Console, KeepsEveryWarningOnceAndInOrderAlsoWhenTheLevelHidesIt) {
  reporter.configure({.level = LogLevel::error});
  reporter.warn("b");
  reporter.warn("a");
  reporter.warn("b");
  EXPECT_EQ(out.str(), "");
  EXPECT_EQ(reporter.warnings(), (std::vector<std::string>{"b", "a"}));
}

TEST_F(Console, ShowsDebugLinesOnlyWhenAsked) {
  reporter.debug("x");
  EXPECT_EQ(out.str(), "");
  reporter.configure({.level = LogLevel::debug});
  reporter.debug("x");
  EXPECT_EQ(out.str(), "rigcal: debug: x\n");
}

TEST_F(Console, KeepsAnErrorOnOneLineWhateverAFileNameHolds) {
  reporter.error("cannot open a\nb\x1b[2J");
  EXPECT_EQ(out.str(), "rigcal: error: cannot open a b [2J\n");
}

TEST(ExitCodes, AreThoseOfTheManual) {
  EXPECT_EQ(static_cast<int>(exit_code_of(Status::good)), 0);
  EXPECT_EQ(static_cast<int>(exit_code_of(Status::weak)), 1);
  EXPECT_EQ(static_cast<int>(exit_code_of(Status::failed)), 1);
  EXPECT_EQ(static_cast<int>(exit_code_of(Error{ErrorKind::cancelled, "stopped", {}, {}})), 1);
  EXPECT_EQ(static_cast<int>(ExitCode::usage), 2);
  EXPECT_EQ(static_cast<int>(exit_code_of(input_error("bad"))), 3);
  EXPECT_EQ(static_cast<int>(exit_code_of(system_error("full"))), 4);
}

}  // namespace
}  // namespace rigcal
