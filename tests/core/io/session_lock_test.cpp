#include "core/io/session_lock.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "tests/core/io/dump_bytes.h"

namespace rigcal {
namespace {

TEST(SessionLock, IsHadByOneUntilItEnds) {
  const std::string session = fresh_path("locked");
  std::filesystem::create_directory(session);
  auto first = SessionLock::take(session);
  ASSERT_TRUE(first);
  EXPECT_FALSE(SessionLock::take(session));
  auto moved = std::move(first);
  first.reset();
  EXPECT_FALSE(SessionLock::take(session));
  moved.reset();
  EXPECT_TRUE(SessionLock::take(session));
  EXPECT_TRUE(std::filesystem::is_empty(session)) << "nothing is left behind";
}

TEST(SessionLock, EndsWithTheProcessThatHasItHoweverThatEnds) {
  const std::string session = fresh_path("killed");
  std::filesystem::create_directory(session);
  int told[2];
  ASSERT_EQ(pipe(told), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto lock = SessionLock::take(session);
    if (write(told[1], lock ? "y" : "n", 1) == 1) pause();
    _exit(0);
  }
  char has_it = 0;
  ASSERT_EQ(read(told[0], &has_it, 1), 1);
  EXPECT_EQ(has_it, 'y');
  EXPECT_FALSE(SessionLock::take(session));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(SessionLock::take(session));
  close(told[0]);
  close(told[1]);
}

TEST(SessionLock, KeepsNobodyOutWhereItIsNotToBeHad) {
  const auto lock = SessionLock::take(fresh_path("nothing"));
  EXPECT_TRUE(lock);
  EXPECT_TRUE(SessionLock::take(fresh_path("nothing")));
}

}  // namespace
}  // namespace rigcal
