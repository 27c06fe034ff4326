#include "drivers/turntable/grbl_protocol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"

namespace rigcal::turntable {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Kind = TableNews::Kind;

/// A protocol past its board's restart.
class Grbl : public testing::Test {
 protected:
  void SetUp() override {
    table.open(0.0);
    table.receive("\r\nGrbl 1.1h ['$' for help]\r\n", 1.0);
    table.tick(2.1);
    EXPECT_EQ(table.take_output(), "?");
  }
  std::vector<TableNews> hear(std::string_view bytes) {
    table.receive(bytes, 3.0);
    return table.take_news();
  }
  void ask(int times = 1) {
    for (int i = 0; i < times; ++i) table.tick(3.0 + i);
    static_cast<void>(table.take_output());
  }
  GrblProtocol table{{'X', 10.0}};
};

TEST_F(Grbl, WaitsForTheBoardToStart) {
  GrblProtocol early({'A', 20.0});
  early.open(5.0);
  early.turn_by(18.0, 5.1);
  early.tick(5.2);
  EXPECT_THAT(early.take_output(), IsEmpty());
  early.tick(7.1);
  early.receive("<Idle|MPos:0.000,0.000,0.000,4.500|FS:0,0>\r\n", 7.2);
  EXPECT_EQ(early.take_output(), "?G91 G21 G94 G1 A18.000 F1200.0\n");
  EXPECT_EQ(early.take_news().at(0).angle_deg, 4.5);
}

// One that rests would be held as well, and take no move of the next run.
TEST_F(Grbl, HoldsOnlyATableThatMoves) {
  table.close();
  EXPECT_THAT(table.take_output(), IsEmpty());
  hear("<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n");
  table.turn_by(18.0, 3.0);
  static_cast<void>(table.take_output());
  table.close();
  EXPECT_EQ(table.take_output(), "!");
}

TEST_F(Grbl, ArrivesOnceItIsIdleAfterItTookTheMove) {
  hear("<Idle|MPos:36.000,0.000,0.000|FS:0,0>\r\n");
  table.turn_by(18.0, 3.0);
  EXPECT_EQ(table.take_output(), "G91 G21 G94 G1 X18.000 F600.0\n");
  // A report from before it knew of the move says idle, too.
  EXPECT_EQ(hear("<Idle|MPos:36.000,0.000,0.000|FS:0,0>\r\n").size(), 1U);
  EXPECT_THAT(hear("ok\r\n"), IsEmpty());
  EXPECT_EQ(hear("<Idle|MPos:36.000,0.000,0.000|FS:0,0>\r\n").size(), 1U);
  ask(2);
  const auto on_its_way = hear("<Run|MPos:40.000,0.000,0.000|FS:600,0>\r\n");
  ASSERT_EQ(on_its_way.size(), 1U);
  EXPECT_EQ(on_its_way[0].angle_deg, 40.0);
  const auto there = hear("<Idle|MPos:54.000,0.000,0.000|FS:0,0>\r\n");
  ASSERT_EQ(there.size(), 2U);
  EXPECT_EQ(there[1].kind, Kind::arrived);
  EXPECT_EQ(there[1].angle_deg, 54.0);
  EXPECT_EQ(hear("<Idle|MPos:54.000,0.000,0.000|FS:0,0>\r\n").size(), 1U);  // Not twice.
}

TEST_F(Grbl, AMoveThatItHasTakenIsNotToldAgain) {
  hear("<Idle|MPos:36.000,0.000,0.000|FS:0,0>\r\n");
  table.turn_by(18.0, 3.0);
  EXPECT_EQ(table.take_output(), "G91 G21 G94 G1 X18.000 F600.0\n");
  hear("ok\r\n<Run|MPos:40.000,0.000,0.000|FS:600,0>\r\n");
  table.turn_by(18.0, 63.0);
  EXPECT_THAT(table.take_output(), IsEmpty());
  ask(2);
  EXPECT_EQ(hear("<Idle|MPos:54.000,0.000,0.000|FS:0,0>\r\n").at(1).kind, Kind::arrived);
  table.turn_by(18.0, 70.0);
  EXPECT_EQ(table.take_output(), "G91 G21 G94 G1 X18.000 F600.0\n");
}

TEST_F(Grbl, AMoveThatGotLostIsToldAgainWithWhatIsMissing) {
  hear("<Idle|MPos:36.000,0.000,0.000|FS:0,0>\r\n");
  table.turn_by(18.0, 3.0);
  static_cast<void>(table.take_output());
  hear("<Idle|MPos:40.000,0.000,0.000|FS:0,0>\r\n");  // Somebody has jogged it.
  table.turn_by(18.0, 63.0);
  EXPECT_EQ(table.take_output(), "G91 G21 G94 G1 X14.000 F600.0\n");
  hear("ok\r\n");
  ask(2);
  EXPECT_EQ(hear("<Idle|MPos:54.000,0.000,0.000|FS:0,0>\r\n").at(1).kind, Kind::arrived);
}

// It counts from zero then, and the table stands where it stood.
TEST_F(Grbl, AnglesGoOnWhereTheBoardRestarts) {
  hear("<Idle|MPos:54.000,0.000,0.000|FS:0,0>\r\n");
  EXPECT_THAT(hear("\r\nGrbl 1.1h ['$' for help]\r\n"), IsEmpty());
  EXPECT_EQ(hear("<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n").at(0).angle_deg, 54.0);
  table.turn_by(18.0, 3.0);
  EXPECT_EQ(table.take_output(), "G91 G21 G94 G1 X18.000 F600.0\n");
  hear("ok\r\n");
  ask(2);
  const auto there = hear("<Idle|MPos:18.000,0.000,0.000|FS:0,0>\r\n");
  ASSERT_EQ(there.size(), 2U);
  EXPECT_EQ(there[1].kind, Kind::arrived);
  EXPECT_EQ(there[1].angle_deg, 72.0);
  // So they do where its port was lost; a board that went on tells what it did meanwhile.
  table.open(10.0);
  table.receive("Grbl 1.1h ['$' for help]\r\n", 11.0);
  table.tick(12.1);
  EXPECT_EQ(hear("<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n").at(0).angle_deg, 72.0);
  table.open(20.0);
  table.tick(22.1);
  EXPECT_EQ(hear("<Idle|MPos:5.000,0.000,0.000|FS:0,0>\r\n").at(0).angle_deg, 77.0);
}

TEST_F(Grbl, AHoldIsToldOnceAndTheMoveGoesOnAfterIt) {
  hear("<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n");
  table.turn_by(18.0, 3.0);
  static_cast<void>(table.take_output());
  hear("ok\r\n<Run|MPos:5.000,0.000,0.000|FS:600,0>\r\n");
  ask(2);
  const auto held = hear("<Hold:1|MPos:7.000,0.000,0.000|FS:0,0>\r\n");
  ASSERT_EQ(held.size(), 2U);
  EXPECT_EQ(held[1].kind, Kind::failed);
  EXPECT_THAT(held[1].text, HasSubstr("the table says Hold:1: let it go on"));
  EXPECT_EQ(hear("<Hold:0|MPos:7.000,0.000,0.000|FS:0,0>\r\n").size(), 1U) << "it was said";
  table.turn_by(18.0, 10.0);
  EXPECT_THAT(table.take_output(), IsEmpty());
  hear("<Run|MPos:9.000,0.000,0.000|FS:600,0>\r\n");
  EXPECT_EQ(hear("<Idle|MPos:18.000,0.000,0.000|FS:0,0>\r\n").at(1).kind, Kind::arrived);
}

TEST_F(Grbl, WhileItIsHeldAtRestItIsToldNothing) {
  hear("<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n");
  EXPECT_THAT(hear("<Door:0|MPos:0.000,0.000,0.000|FS:0,0>\r\n").at(1).text, HasSubstr("Door:0"));
  for (int i = 0; i < 2; ++i) table.turn_by(18.0, 3.0);
  ask();
  hear("<Door:0|MPos:0.000,0.000,0.000|FS:0,0>\r\n");
  EXPECT_THAT(table.take_output(), IsEmpty());
  hear("<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n");
  EXPECT_EQ(table.take_output(), "G91 G21 G94 G1 X18.000 F600.0\n");
}

// Boards that do not restart when their port is opened are still held within the last move of the run before.
TEST_F(Grbl, AHoldThatARunHasLeftIsDroppedWithItsMove) {
  table.turn_by(18.0, 3.0);
  EXPECT_EQ(hear("<Hold:1|MPos:6.000,0.000,0.000|FS:0,0>\r\n").size(), 1U);
  EXPECT_THAT(table.take_output(), IsEmpty()) << "it still slows down";
  EXPECT_EQ(hear("<Hold:0|MPos:7.000,0.000,0.000|FS:0,0>\r\n").size(), 1U);
  EXPECT_EQ(table.take_output(), "\x18");
  EXPECT_THAT(hear("Grbl 1.1h ['$' for help]\r\n"), IsEmpty());
  table.tick(3.1);
  EXPECT_THAT(table.take_output(), IsEmpty()) << "it would be lost";
  table.tick(5.1);
  EXPECT_EQ(table.take_output(), "?");
  EXPECT_EQ(hear("<Idle|MPos:7.000,0.000,0.000|FS:0,0>\r\n").at(0).angle_deg, 7.0) << "it keeps its position";
  EXPECT_EQ(table.take_output(), "G91 G21 G94 G1 X18.000 F600.0\n");
  EXPECT_EQ(hear("<Run|MPos:8.000,0.000,0.000|FS:600,0>\r\n").at(0).angle_deg, 8.0);
  // Another one is somebody's wish.
  EXPECT_THAT(hear("<Hold:0|MPos:9.000,0.000,0.000|FS:0,0>\r\n").at(1).text, HasSubstr("Hold:0"));
  EXPECT_THAT(table.take_output(), IsEmpty());
}

TEST_F(Grbl, AnAlarmIsToldAlsoWhereItRests) {
  const auto news = hear("<Alarm|MPos:0.000,0.000,0.000|FS:0,0>\r\n");
  ASSERT_EQ(news.size(), 2U);
  EXPECT_THAT(news[1].text, HasSubstr("the table says Alarm: unlock it"));
  EXPECT_EQ(hear("<Alarm|MPos:0.000,0.000,0.000|FS:0,0>\r\n").size(), 1U);
  EXPECT_THAT(table.take_output(), IsEmpty()) << "somebody has to look at it";
}

TEST_F(Grbl, ReportsOfTheWorkPositionAreReadToo) {
  EXPECT_EQ(hear("<Idle|WPos:-1.250,0.000,0.000|FS:0,0>\r\n").at(0).angle_deg, -1.25);
  // In pieces, as a serial line brings them.
  EXPECT_THAT(hear("<Idle|MPo"), IsEmpty());
  EXPECT_EQ(hear("s:2.5,0,0>\n").at(0).angle_deg, 2.5);
}

TEST_F(Grbl, SaysWhyItFailed) {
  hear("<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n");
  table.turn_by(18.0, 3.0);
  EXPECT_THAT(hear("error:9\r\n").at(0).text, HasSubstr("error:9"));
  table.turn_by(18.0, 3.0);
  EXPECT_THAT(hear("ALARM:1\r\n").at(0).text, HasSubstr("ALARM:1"));
  table.turn_by(18.0, 3.0);
  hear("ok\r\n");
  EXPECT_THAT(hear("<Alarm|MPos:3.000,0.000,0.000|FS:0,0>\r\n").at(1).text, HasSubstr("Alarm"));
  table.turn_by(18.0, 3.0);
  EXPECT_THAT(hear("Grbl 1.1h ['$' for help]\r\n").at(0).text, HasSubstr("restarted"));
}

TEST_F(Grbl, StoppingElsewhereIsAFault) {
  hear("<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n");
  table.turn_by(18.0, 3.0);
  hear("ok\r\n");
  ask(2);
  const auto news = hear("<Idle|MPos:11.000,0.000,0.000|FS:0,0>\r\n");
  ASSERT_EQ(news.size(), 2U);
  EXPECT_EQ(news[1].kind, Kind::failed);
  EXPECT_THAT(news[1].text, HasSubstr("-7.00 degrees off"));
}

TEST_F(Grbl, AnyBytesAreSafe) {
  Random random(7);
  const std::string words[] = {
      "<", ">", "|MPos:", "Idle", "ok\n", "error:", "\n", "nan", ",", "1e400", "\xff", "Grbl "};
  for (int i = 0; i < 20'000; ++i) {
    table.receive(words[random.below(12)], 3.0);
    if (i % 7 == 0) table.turn_by(1.0, 3.0);
    if (i % 5 == 0) table.tick(3.0);
    for (const TableNews& news : table.take_news()) EXPECT_LE(std::abs(news.angle_deg), 1e6);
    EXPECT_LE(table.take_output().size(), 200U);
  }
}

}  // namespace
}  // namespace rigcal::turntable
