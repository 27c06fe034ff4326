#include "core/base/parse_number.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace rigcal {
namespace {

TEST(ParseNumber, TakesWholeTextsOnly) {
  EXPECT_EQ(parse_number<int>("-12"), -12);
  EXPECT_EQ(parse_number<double>("1.5e3"), 1500.0);
  EXPECT_EQ(parse_number<std::uint32_t>("7F", 16), 0x7FU);
  for (const char* text : {"", " 1", "1 ", "+1", "1.5", "1x", "-", "x"}) EXPECT_FALSE(parse_number<int>(text)) << text;
  for (const char* text : {"", " 1", "1 ", "+1", "1e", "0x1"}) EXPECT_FALSE(parse_number<double>(text)) << text;
}

TEST(ParseNumber, RefusesWhatDoesNotFitOrIsNotFinite) {
  EXPECT_EQ(parse_number<std::uint8_t>("255"), 255);
  EXPECT_FALSE(parse_number<std::uint8_t>("256"));
  EXPECT_FALSE(parse_number<std::uint8_t>("-1"));
  for (const char* text : {"inf", "-inf", "nan", "1e999", "1e-999"}) EXPECT_FALSE(parse_number<double>(text)) << text;
}

TEST(ParseNumber, CutsOffWhatItTook) {
  std::string_view text = "12.5 mm";
  EXPECT_EQ(take_number<double>(text), 12.5);
  EXPECT_EQ(text, " mm");
  EXPECT_FALSE(take_number<double>(text));
  EXPECT_EQ(text, " mm");
}

}  // namespace
}  // namespace rigcal
