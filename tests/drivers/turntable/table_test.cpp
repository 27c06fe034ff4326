// The table's thread against a virtual table on a pseudo-terminal.
#include "drivers/turntable/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <thread>

#include "simdata/live/virtual_table.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::turntable {
namespace {

using testing::HasSubstr;
using Kind = TableNews::Kind;

TableOptions options_of(const sim::VirtualTable& table, ProtocolKind protocol) {
  TableOptions options;
  options.port = table.port();
  options.protocol = protocol;
  return options;
}

/// Waits for news of a kind, 8 s at most.
std::optional<TableEvent> await(Table& table, Kind kind) {
  for (int i = 0; i < 800; ++i) {
    for (const TableEvent& event : table.take_events()) {
      if (event.kind == kind) return event;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return std::nullopt;
}

class TableOnALine : public testing::TestWithParam<ProtocolKind> {
 protected:
  void SetUp() override {
    sim::VirtualTableOptions virtual_options;
    virtual_options.speaks_grbl = GetParam() == ProtocolKind::grbl;
    virtual_options.degrees_per_s = 90.0;
    auto made = sim::VirtualTable::start(virtual_options);
    if (!made) GTEST_SKIP() << made.error().message();
    other_end = *std::move(made);
    auto started = Table::start(options_of(*other_end, GetParam()), net::read_clocks());
    ASSERT_TRUE(started) << started.error().message();
    table = *std::move(started);
  }
  std::unique_ptr<sim::VirtualTable> other_end;
  std::unique_ptr<Table> table;
};

TEST_P(TableOnALine, TurnsAndArrives) {
  for (const double expected : {18.0, 36.0}) {
    table->turn_by(18.0);
    const auto arrived = await(*table, Kind::arrived);
    ASSERT_TRUE(arrived.has_value());
    EXPECT_NEAR(arrived->angle_deg, expected, 1e-3);
    EXPECT_NEAR(other_end->angle_deg(), expected, 1e-3);
    EXPECT_GT(arrived->stamp_ns, 1'600'000'000'000'000'000);
  }
  EXPECT_NEAR(*table->angle_deg(), 36.0, 1e-3);
}

TEST_P(TableOnALine, AJammedTableDoesNotArrive) {
  ASSERT_TRUE(await(*table, Kind::angle).has_value());
  other_end->jam(true);
  table->turn_by(18.0);
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  for (const TableEvent& event : table->take_events()) EXPECT_EQ(event.kind, Kind::angle);
  other_end->jam(false);
  EXPECT_TRUE(await(*table, Kind::arrived).has_value());
}

TEST_P(TableOnALine, AnglesRunAsTheRigFileSaysAlsoWhereThePortIsGone) {
  table.reset();
  TableOptions reversed = options_of(*other_end, GetParam());
  reversed.is_reversed = true;
  auto started = Table::start(reversed, net::read_clocks());
  ASSERT_TRUE(started.has_value());
  (*started)->turn_by(10.0);
  const auto arrived = await(**started, Kind::arrived);
  ASSERT_TRUE(arrived.has_value());
  EXPECT_NEAR(arrived->angle_deg, 10.0, 1e-3);
  EXPECT_NEAR(other_end->angle_deg(), -10.0, 1e-3);
  other_end.reset();
  ASSERT_TRUE(await(**started, Kind::failed).has_value());
  EXPECT_NEAR(*(*started)->angle_deg(), 10.0, 1e-3);
}

TEST_P(TableOnALine, ATableThatIsGoneIsSaid) {
  ASSERT_TRUE(await(*table, Kind::angle).has_value());
  other_end.reset();
  const auto failed = await(*table, Kind::failed);
  ASSERT_TRUE(failed.has_value());
  EXPECT_THAT(failed->text, HasSubstr("serial port is gone"));
}

INSTANTIATE_TEST_SUITE_P(Protocols, TableOnALine, testing::Values(ProtocolKind::grbl, ProtocolKind::ascii),
                         [](const auto& named) { return named.param == ProtocolKind::grbl ? "Grbl" : "Ascii"; });

TEST(Table, FollowsARunThatTurnsByItself) {
  auto other_end = sim::VirtualTable::start({});
  if (!other_end) GTEST_SKIP() << other_end.error().message();
  (*other_end)->follow(0.0);
  auto table = Table::start(options_of(**other_end, ProtocolKind::grbl), net::read_clocks());
  ASSERT_TRUE(table.has_value());
  ASSERT_TRUE(await(**table, Kind::angle).has_value());
  (*table)->turn_by(18.0);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  for (const TableEvent& event : (*table)->take_events()) EXPECT_EQ(event.kind, Kind::angle);
  for (int i = 1; i <= 18; ++i) (*other_end)->follow(i);
  const auto arrived = await(**table, Kind::arrived);
  ASSERT_TRUE(arrived.has_value());
  EXPECT_NEAR(arrived->angle_deg, 18.0, 1e-3);
}

TEST(Table, OneThatARunHasLeftWithinAMoveTurnsInTheNext) {
  auto other_end = sim::VirtualTable::start({});
  if (!other_end) GTEST_SKIP() << other_end.error().message();
  auto table = Table::start(options_of(**other_end, ProtocolKind::grbl), net::read_clocks());
  ASSERT_TRUE(table.has_value());
  (*table)->turn_by(100.0);
  for (int i = 0; i < 500 && (*other_end)->angle_deg() < 10.0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  table->reset();
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const double held_deg = (*other_end)->angle_deg();
  EXPECT_LT(held_deg, 100.0);
  table = Table::start(options_of(**other_end, ProtocolKind::grbl), net::read_clocks());
  ASSERT_TRUE(table.has_value());
  (*table)->turn_by(5.0);
  const auto arrived = await(**table, Kind::arrived);
  ASSERT_TRUE(arrived.has_value());
  EXPECT_NEAR(arrived->angle_deg, held_deg + 5.0, 1e-3);
}

TEST(Table, PortsThatCannotBeHadAreRefused) {
  const auto folder = scratch_folder("table");
  TableOptions options;
  options.port = (folder / "nothing").string();
  auto refused = Table::start(options, net::read_clocks());
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message(), HasSubstr("there is no such serial port"));
  options.port = "/dev/null";
  EXPECT_THAT(Table::start(options, net::read_clocks()).error().message(), HasSubstr("is no serial port"));
  options.baud = 12345;
  EXPECT_THAT(Table::start(options, net::read_clocks()).error().message(), HasSubstr("12345 baud"));
  options.protocol = ProtocolKind::ascii;
  options.ascii.move = "GO";
  EXPECT_THAT(Table::start(options, net::read_clocks()).error().message(), HasSubstr("neither {angle} nor {step}"));
}

TEST(VirtualTable, CanBeReachedByALink) {
  const auto folder = scratch_folder("table_link");
  sim::VirtualTableOptions linked;
  linked.link = (folder / "table").string();
  {
    auto other_end = sim::VirtualTable::start(linked);
    if (!other_end) GTEST_SKIP() << other_end.error().message();
    EXPECT_EQ(std::filesystem::read_symlink(linked.link).string(), (*other_end)->port());
  }
  EXPECT_FALSE(std::filesystem::is_symlink(linked.link));
  linked.link = (folder / "missing" / "table").string();
  EXPECT_FALSE(sim::VirtualTable::start(linked).has_value());
}

}  // namespace
}  // namespace rigcal::turntable
