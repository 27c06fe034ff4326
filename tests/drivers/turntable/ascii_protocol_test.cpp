#include "drivers/turntable/ascii_protocol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal::turntable {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Kind = TableNews::Kind;

std::vector<TableNews> hear(AsciiProtocol& table, std::string_view bytes) {
  table.receive(bytes, 0.0);
  return table.take_news();
}

/// Of a table that cannot be asked, and says OK when it is there.
AsciiOptions of_no_answers(const std::string& move) {
  AsciiOptions words;
  words.move = move;
  words.ask = "";
  words.done = "OK";
  return words;
}

TEST(AsciiProtocol, TurnsFromWhereItIsToWhereItIsTold) {
  AsciiProtocol table({});
  table.open(0.0);
  table.turn_by(18.0, 0.0);
  EXPECT_THAT(table.take_output(), IsEmpty());  // From where?
  table.tick(0.1);
  EXPECT_EQ(table.take_output(), "POS?\n");
  EXPECT_EQ(hear(table, "POS 10.5\r\n").size(), 1U);
  EXPECT_EQ(table.take_output(), "MOVE 28.500\n");
  EXPECT_EQ(hear(table, "POS 20\n").size(), 1U);
  EXPECT_EQ(hear(table, "POS 28.45\n").size(), 1U);
  const auto there = hear(table, "POS 28.5\n");
  ASSERT_EQ(there.size(), 2U);
  EXPECT_EQ(there[1].kind, Kind::arrived);
  // The next step is counted from where it was told to go: what is missing does not add up.
  table.turn_by(18.0, 1.0);
  EXPECT_EQ(table.take_output(), "MOVE 46.500\n");
}

TEST(AsciiProtocol, TablesThatCountWithinATurnArriveToo) {
  AsciiProtocol table({});
  hear(table, "POS 350\n");
  table.turn_by(18.0, 0.0);
  EXPECT_EQ(table.take_output(), "MOVE 368.000\n");
  hear(table, "POS 8.0\n");
  EXPECT_EQ(hear(table, "POS 8.0\n").at(1).kind, Kind::arrived);
}

TEST(AsciiProtocol, ATurnThatIsToldAgainOnItsWayEndsWhereItWasToEnd) {
  AsciiOptions words;
  words.move = "MOVE {angle} BY {step}";
  AsciiProtocol table(words);
  hear(table, "POS 350\n");
  table.turn_by(18.0, 0.0);
  EXPECT_EQ(table.take_output(), "MOVE 368.000 BY 18.000\n");
  hear(table, "POS 355.5\n");
  table.turn_by(18.0, 60.0);
  EXPECT_EQ(table.take_output(), "MOVE 368.000 BY 12.500\n");
  hear(table, "POS 1\n");
  table.turn_by(18.0, 120.0);
  EXPECT_EQ(table.take_output(), "MOVE 368.000 BY 7.000\n");
  hear(table, "POS 8\n");
  EXPECT_EQ(hear(table, "POS 8\n").at(1).kind, Kind::arrived);
  table.turn_by(18.0, 130.0);
  EXPECT_EQ(table.take_output(), "MOVE 386.000 BY 18.000\n");
}

TEST(AsciiProtocol, ATurnThatIsToldAgainIsTheSameWhereNobodyKnowsTheAngle) {
  AsciiProtocol table(of_no_answers("TO {angle} BY {step}"));
  table.open(0.0);
  for (int i = 0; i < 2; ++i) {
    table.turn_by(18.0, 60.0 * i);
    EXPECT_EQ(table.take_output(), "TO 18.000 BY 18.000\n");
  }
  EXPECT_EQ(hear(table, "OK\n").at(0).angle_deg, 18.0);
}

// Its answer may have got lost, not the step.
TEST(AsciiProtocol, AStepOfATableThatCannotBeAskedIsNotToldTwice) {
  AsciiProtocol table(of_no_answers("R{step};"));
  table.open(0.0);
  table.turn_by(18.0, 0.0);
  EXPECT_EQ(table.take_output(), "R18.000;\n");
  table.turn_by(18.0, 60.0);
  EXPECT_THAT(table.take_output(), IsEmpty());
  table.open(70.0);
  table.turn_by(18.0, 71.0);
  EXPECT_THAT(table.take_output(), IsEmpty());
  EXPECT_EQ(hear(table, "OK\n").at(1).kind, Kind::arrived);
  table.turn_by(18.0, 80.0);
  EXPECT_EQ(table.take_output(), "R18.000;\n");
  EXPECT_EQ(hear(table, "OK\n").at(0).angle_deg, 36.0);
}

TEST(AsciiProtocol, WhereItsLineIsOpenedAnewItsAnglesGoOn) {
  AsciiProtocol table(of_no_answers("TO {angle}"));
  table.open(0.0);
  table.turn_by(18.0, 0.0);
  EXPECT_EQ(table.take_output(), "TO 18.000\n");
  EXPECT_EQ(hear(table, "OK\n").at(0).angle_deg, 18.0);
  table.open(60.0);  // It counts from zero again.
  table.turn_by(18.0, 61.0);
  EXPECT_EQ(table.take_output(), "TO 18.000\n");
  EXPECT_EQ(hear(table, "OK\n").at(0).angle_deg, 36.0);
}

TEST(AsciiProtocol, WordsOfItsOwn) {
  AsciiOptions words = of_no_answers("R{step};");
  words.fault = "!";
  ASSERT_EQ(fault_of(words), "");
  AsciiProtocol table(words);
  table.open(0.0);
  table.tick(0.1);
  table.turn_by(-7.5, 0.0);
  EXPECT_EQ(table.take_output(), "R-7.500;\n");
  EXPECT_THAT(hear(table, "busy\n"), IsEmpty());
  const auto news = hear(table, "OK\n");
  ASSERT_EQ(news.size(), 2U);
  EXPECT_EQ(news[0].angle_deg, -7.5);
  EXPECT_EQ(news[1].kind, Kind::arrived);
  EXPECT_THAT(hear(table, "OK\n"), IsEmpty());
  table.turn_by(1.0, 0.0);
  EXPECT_THAT(hear(table, "!limit\n").at(0).text, HasSubstr("!limit"));
}

TEST(AsciiProtocol, WordsThatCannotWorkAreRefused) {
  AsciiOptions words;
  EXPECT_EQ(fault_of(words), "");
  words.move = "GO";
  EXPECT_THAT(fault_of(words), HasSubstr("neither {angle} nor {step}"));
  words = {};
  words.answer = "AT";
  EXPECT_THAT(fault_of(words), HasSubstr("answer has no {angle}"));
  words = {};
  words.ask = "";
  EXPECT_THAT(fault_of(words), HasSubstr("without ask or done"));
  words = {};
  words.fault = "a\nb";
  EXPECT_THAT(fault_of(words), HasSubstr("plain ASCII"));
}

TEST(AsciiProtocol, LinesOfNoiseCostNoMemory) {
  AsciiProtocol table({});
  for (int i = 0; i < 1000; ++i) EXPECT_THAT(hear(table, std::string(1000, 'x')), IsEmpty());
  hear(table, "\n");
  EXPECT_EQ(hear(table, "POS 3\n").size(), 1U);
  for (const char* line : {"POS\n", "POS x\n", "POS 1e9\n", "POS nan\n", "pos 3\n"})
    EXPECT_THAT(hear(table, line), IsEmpty()) << line;
}

}  // namespace
}  // namespace rigcal::turntable
