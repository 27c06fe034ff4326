#include "apps/capture/session_keeper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "apps/capture/disk_watch.h"
#include "tests/support/comes_true.h"
#include "tests/support/files.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(SessionKeeper, TellsAtOnceThatTheSessionIsGone) {
  const std::filesystem::path folder = scratch_folder("session_keeper");
  SessionKeeper keeper(folder.string());
  keeper.secure({});
  EXPECT_TRUE(comes_true([&] { return keeper.secured() == 1; }));
  EXPECT_TRUE(std::filesystem::exists(folder / "session.json"));
  EXPECT_FALSE(keeper.failure().has_value());
  EXPECT_TRUE(free_bytes(folder.string()).has_value());
  std::filesystem::remove_all(folder);
  EXPECT_FALSE(free_bytes(folder.string()).has_value());
  keeper.secure({});
  ASSERT_TRUE(comes_true([&] { return keeper.failure().has_value(); }));
  EXPECT_EQ(keeper.failure()->kind, ErrorKind::system);
  EXPECT_THAT(keeper.failure()->message(), HasSubstr("session.json"));
  EXPECT_EQ(keeper.secured(), 1U);
}

TEST(SessionKeeper, CountsAsSecuredOnlyWhatTheDiskTook) {
  const std::filesystem::path folder = scratch_folder("session_keeper");
  std::atomic<bool> is_broken = true;
  SessionKeeper keeper(folder.string(), [&](const std::string& session) -> Expected<void> {
    if (!is_broken) return sync_session(session);
    return system_error("the disk lost some of what was recorded", session, "look after it");
  });
  keeper.secure({});
  ASSERT_TRUE(comes_true([&] { return keeper.loss().has_value(); }));
  EXPECT_THAT(keeper.loss()->message(), HasSubstr(folder.string()));
  EXPECT_EQ(keeper.secured(), 0U);
  EXPECT_FALSE(keeper.failure().has_value()) << "what still comes may be worth having";
  is_broken = false;
  keeper.secure({});
  EXPECT_TRUE(comes_true([&] { return keeper.secured() == 1; }));
  EXPECT_TRUE(keeper.finish(std::chrono::seconds(60)));
  EXPECT_TRUE(keeper.loss().has_value()) << "is not taken back";
}

TEST(SessionKeeper, ALossWhileItEndsIsToldToo) {
  const std::filesystem::path folder = scratch_folder("session_keeper");
  SessionKeeper keeper(folder.string(), [](const std::string& session) -> Expected<void> {
    return system_error("the disk lost some of what was recorded", session, "look after it");
  });
  keeper.stop_writing();
  EXPECT_FALSE(keeper.finish(std::chrono::seconds(60)));
  EXPECT_TRUE(keeper.loss().has_value());
  EXPECT_FALSE(std::filesystem::exists(folder / "session.json"));
}

TEST(SessionKeeper, ADiskThatDoesNotAnswerKeepsNobodyFromEnding) {
  const std::filesystem::path folder = scratch_folder("session_keeper");
  struct Disk {
    std::atomic<int> asked{0};
    std::atomic<bool> answers{false};
  };
  const auto disk = std::make_shared<Disk>();
  SessionKeeper keeper(folder.string(), [disk](const std::string&) -> Expected<void> {
    ++disk->asked;
    while (!disk->answers) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return {};
  });
  SessionRecord record;
  record.software = "first";
  keeper.secure(record);
  ASSERT_TRUE(comes_true([&] { return disk->asked == 1; }));
  record.software = "second";
  keeper.secure(record);  // Waits behind the disk, and must not be written over the caller's last one.
  keeper.stop_writing();
  ASSERT_TRUE(write_session_record(folder.string(), {}));
  EXPECT_FALSE(keeper.finish(std::chrono::milliseconds(20)));
  EXPECT_FALSE(keeper.failure().has_value());
  EXPECT_FALSE(keeper.loss().has_value());
  disk->answers = true;
  EXPECT_TRUE(comes_true([&] { return disk->asked == 2; })) << "the last sync comes all the same";
  const std::string left = text_of(folder / "session.json");
  EXPECT_THAT(left, HasSubstr("software"));
  EXPECT_THAT(left, Not(HasSubstr("second")));
}

}  // namespace
}  // namespace rigcal
