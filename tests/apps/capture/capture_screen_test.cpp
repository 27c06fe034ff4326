#include "apps/capture/capture_screen.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Keeps what was said; takes nothing while it is shut.
class Terminal final : public Reporter {
 public:
  void progress(std::string_view stage, double) override {
    wait();
    said.push_back("at " + std::string(stage));
  }
  void warn(std::string message) override {
    wait();
    said.push_back("warning: " + message);
  }
  void debug(std::string message) override {
    wait();
    said.push_back(message);
  }
  void draw(const CaptureStatus& status) {
    wait();
    said.push_back(std::to_string(status.bytes));
  }

  void tell(const std::string& line) {
    wait();
    said.push_back("told: " + line);
  }

  std::atomic<bool> is_shut{false};
  std::atomic<int> waiting{0};
  std::vector<std::string> said;

 private:
  void wait() {
    ++waiting;
    while (is_shut) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    --waiting;
  }
};

CaptureStatus with_bytes(std::uint64_t bytes) {
  CaptureStatus status;
  status.bytes = bytes;
  return status;
}

/// A screen that waits for its terminal with the first status.
class CaptureScreenTest : public testing::Test {
 protected:
  CaptureScreenTest() {
    terminal.is_shut = true;
    screen.show(with_bytes(1));
    while (terminal.waiting == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  Terminal terminal;
  CaptureScreen screen{terminal, [this](const CaptureStatus& status) { terminal.draw(status); },
                       [this](const std::string& line) { terminal.tell(line); }};
};

TEST_F(CaptureScreenTest, ATerminalThatTakesNothingHoldsNobodyUp) {
  for (std::uint64_t bytes = 2; bytes < 100; ++bytes) screen.show(with_bytes(bytes));
  screen.progress("stage", 0.5);
  screen.warn("the disk fills");
  screen.debug("a remark");
  screen.tell("a line");
  terminal.is_shut = false;
  screen.finish();
  // What was begun, then what was said, then the newest status.
  EXPECT_THAT(terminal.said, ElementsAre("1", "warning: the disk fills", "a remark", "told: a line", "99"));
}

TEST_F(CaptureScreenTest, ShowsProgressOnceNoStatusDoes) {
  screen.progress("capture", 0.5);
  screen.show(with_bytes(2));
  screen.show_progress();
  screen.progress("poses", 0.5);
  screen.progress("joint", 0.5);
  terminal.is_shut = false;
  screen.finish();
  EXPECT_THAT(terminal.said, ElementsAre("1", "2", "at joint"));
}

TEST_F(CaptureScreenTest, KeepsABoundedNumberOfSentencesAndSaysHowManyItLeftOut) {
  for (int i = 0; i < 1000; ++i) screen.debug("sentence " + std::to_string(i));
  terminal.is_shut = false;
  screen.finish();
  ASSERT_EQ(terminal.said.size(), 1U + 256U + 1U);
  EXPECT_EQ(terminal.said[256], "sentence 255");
  EXPECT_THAT(terminal.said.back(), HasSubstr("744 messages"));
}

}  // namespace
}  // namespace rigcal
