#include "apps/common/stop_signal.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <condition_variable>
#include <csignal>
#include <mutex>
#include <thread>

namespace rigcal {
namespace {

// Waits for the stop, not for a time; a stop that never comes runs into the test's own time limit.
void wait_for(const std::stop_token& token) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  stopped.wait(lock, token, [] { return false; });
}

TEST(StopSignal, TurnsSigtermIntoAStopRequestInsteadOfEndingTheProgram) {
  const StopSignal signal;
  ASSERT_TRUE(signal.ready());
  EXPECT_FALSE(signal.token().stop_requested());
  ASSERT_EQ(kill(getpid(), SIGTERM), 0);
  wait_for(signal.token());
  EXPECT_TRUE(signal.token().stop_requested());
}

TEST(StopSignal, TheEndOfTheTerminalIsOneToo) {
  const StopSignal signal;
  ASSERT_EQ(kill(getpid(), SIGHUP), 0);
  wait_for(signal.token());
  // The shell and the system may both say it; that is no second wish.
  ASSERT_EQ(kill(getpid(), SIGHUP), 0);
  usleep(100'000);
  EXPECT_TRUE(signal.token().stop_requested());
}

TEST(StopSignal, EndsItsThreadWithoutASignal) {
  const StopSignal signal;
  EXPECT_FALSE(signal.token().stop_requested());
}

TEST(StopSignalDeathTest, WhatNohupIgnoresIsIgnored) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        std::signal(SIGHUP, SIG_IGN);
        const StopSignal signal;
        kill(getpid(), SIGHUP);
        kill(getpid(), SIGINT);  // The second one, if that was one.
        wait_for(signal.token());
        usleep(100'000);
        _exit(7);
      },
      testing::ExitedWithCode(7), "");
}

TEST(StopSignalDeathTest, ASecondSignalEndsTheProgramAtOnce) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        const StopSignal signal;
        kill(getpid(), SIGINT);
        wait_for(signal.token());
        std::this_thread::sleep_for(StopSignal::kOneWish);
        kill(getpid(), SIGINT);
        pause();
      },
      testing::ExitedWithCode(1), "error: ended at once by a second signal.*--repair");
}

// A terminal that was stopped, a pipe that nobody reads: words would wait for ever.
void say_to_nobody() {
  int ends[2];
  if (pipe(ends) != 0 || fcntl(ends[1], F_SETFL, O_NONBLOCK) != 0) _exit(8);
  while (write(ends[1], "full", 4) > 0) continue;
  fcntl(ends[1], F_SETFL, 0);
  dup2(ends[1], STDERR_FILENO);
}

TEST(StopSignalDeathTest, ASecondSignalEndsAProgramToWhichNobodyListens) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        say_to_nobody();
        const StopSignal signal;
        kill(getpid(), SIGINT);
        wait_for(signal.token());
        std::this_thread::sleep_for(StopSignal::kOneWish);
        kill(getpid(), SIGINT);
        sleep(10);
        _exit(9);
      },
      testing::ExitedWithCode(1), "");
}

TEST(StopSignalDeathTest, OneThatIsSentTwiceIsOneWish) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        const StopSignal signal;
        kill(getpid(), SIGINT);
        wait_for(signal.token());
        kill(getpid(), SIGINT);  // As timeout does, to its child and to the child's group.
        usleep(100'000);
        _exit(7);
      },
      testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace rigcal
