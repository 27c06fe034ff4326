#include "apps/capture/disk_wait.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>

#include "tests/support/comes_true.h"

namespace rigcal {
namespace {

using std::chrono::milliseconds;

/// A patience that is soon over, and what came of it.
struct Waited {
  Waited() {
    patience.told_after = milliseconds(20);
    patience.most = milliseconds(200);
    patience.tell = [this](const std::string& what) {
      told_what = what;
      ++told;
    };
    patience.give_up = [this](std::chrono::nanoseconds waited) {
      given_up_after = waited;
      ++given_up;
    };
  }
  DiskPatience patience;
  std::string told_what;  ///< To be read once the wait is over.
  std::chrono::nanoseconds given_up_after{0};
  std::atomic<int> told{0};
  std::atomic<int> given_up{0};
};

TEST(DiskWait, IsSilentWhereTheDiskTakesItInTime) {
  Waited waited;
  waited.patience.told_after = std::chrono::seconds(30);
  { const DiskWait wait(waited.patience, "the packets", nullptr); }
  EXPECT_EQ(waited.told, 0);
  EXPECT_EQ(waited.given_up, 0);
}

TEST(DiskWait, SaysOnceWhatIsWaitedForAndGivesUp) {
  Waited waited;
  Heartbeat blocked("packets");
  blocked.beat();
  {
    const DiskWait wait(waited.patience, "the packets", &blocked);
    EXPECT_TRUE(comes_true([&] { return waited.given_up == 1; }));
    std::this_thread::sleep_for(milliseconds(300));
  }
  EXPECT_EQ(waited.told_what, "the packets");
  EXPECT_EQ(waited.told, 1);
  EXPECT_EQ(waited.given_up, 1);
}

TEST(DiskWait, DoesNotGiveUpADiskThatIsSlow) {
  Waited waited;
  waited.patience.most = milliseconds(2500);
  waited.patience.told_after = milliseconds(2000);
  Heartbeat slow("packets");
  slow.beat();
  {
    const DiskWait wait(waited.patience, "the packets", &slow);
    for (int i = 0; i < 60; ++i) {  // Longer than that in all.
      std::this_thread::sleep_for(milliseconds(50));
      slow.beat();
    }
  }
  EXPECT_EQ(waited.told, 0);
  EXPECT_EQ(waited.given_up, 0);
}

// What it blocked before counts for nothing: only since the wait there is nothing else to do.
TEST(DiskWait, CountsFromItsOwnBeginAndWithoutAThreadThatMoves) {
  Waited waited;
  waited.patience.most = std::chrono::seconds(30);
  Heartbeat blocked("packets");
  blocked.beat();
  std::this_thread::sleep_for(milliseconds(600));
  waited.patience.told_after = milliseconds(500);
  {
    const DiskWait wait(waited.patience, "the packets", &blocked);
    std::this_thread::sleep_for(milliseconds(20));
  }
  EXPECT_EQ(waited.told, 0);
  {
    const DiskWait wait(waited.patience, "session.json", nullptr);
    EXPECT_TRUE(comes_true([&] { return waited.told == 1; }));
  }
  EXPECT_EQ(waited.told_what, "session.json");
}

// Nothing tells a disk that is blocked from one that takes long over what it was given.
TEST(DiskWait, IsMorePatientWithoutAThreadThatMoves) {
  Waited waited;
  waited.patience.most_unseen = milliseconds(800);
  {
    const DiskWait wait(waited.patience, "session.json", nullptr);
    std::this_thread::sleep_for(milliseconds(450));
    EXPECT_EQ(waited.given_up, 0);
    EXPECT_TRUE(comes_true([&] { return waited.given_up == 1; }));
  }
  EXPECT_EQ(waited.given_up_after, milliseconds(800));
}

}  // namespace
}  // namespace rigcal
