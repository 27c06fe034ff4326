#include "core/base/text.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "core/base/utc_text.h"

namespace rigcal {
namespace {

TEST(NumberText, ReadsBackToTheSameBits) {
  for (const double value : {1.0 / 3.0, -2e-5, 1e300, 5e-324, 0.1, 123456789.123456789, 1e22}) {
    EXPECT_EQ(std::strtod(number_text(value).c_str(), nullptr), value) << number_text(value);
  }
}

TEST(FixedText, RoundsAndKnowsNoMinusZero) {
  EXPECT_EQ(fixed_text(1.2345, 2), "1.23");
  EXPECT_EQ(fixed_text(-0.06, 1), "-0.1");
  EXPECT_EQ(fixed_text(-0.04, 1), "0.0");
  EXPECT_EQ(fixed_text(-0.4, 0), "0");
  EXPECT_EQ(fixed_text(-10.0, 0), "-10");
  EXPECT_EQ(fixed_text(1e300, 1).size(), 303U);
}

TEST(NumberText, AlwaysHasAPointSoThatYamlReadersTakeItForANumber) {
  EXPECT_EQ(number_text(1.0), "1.0");
  EXPECT_EQ(number_text(-0.0), "0.0");
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(number_text(1e-5), "1.0e-05");
  EXPECT_EQ(number_text(1e22), "1.0e+22");
  EXPECT_EQ(number_text(-std::numeric_limits<double>::infinity()), "-.inf");
  EXPECT_EQ(number_text(std::numeric_limits<double>::quiet_NaN()), ".nan");
}

TEST(Counted, IsOneOrMany) {
  EXPECT_EQ(counted(0, "stop"), "0 stops");
  EXPECT_EQ(counted(1, "stop"), "1 stop");
  EXPECT_EQ(counted(2, "stop"), "2 stops");
}

TEST(Joined, HasTheSeparatorInBetween) {
  EXPECT_EQ(joined({}, ", "), "");
  EXPECT_EQ(joined({"a"}, ", "), "a");
  EXPECT_EQ(joined({"a", "b", "c"}, "; "), "a; b; c");
  EXPECT_EQ(joined_some({"a", "b", "c"}, 3), "a, b, c");
  EXPECT_EQ(joined_some({"a", "b", "c"}, 2), "a, b and 1 more");
}

TEST(SmallLetters, AreMadeOfThoseOfAsciiAlone) {
  EXPECT_EQ(small_letters("BayerRG8_\xC3\x84.PNG"), "bayerrg8_\xC3\x84.png");
  EXPECT_EQ(small_letters(""), "");
}

TEST(KeyText, QuotesWhatAReaderWouldTakeForSomethingElse) {
  EXPECT_EQ(key_text("mid100_left"), "mid100_left");
  EXPECT_EQ(key_text("no"), "\"no\"");
  EXPECT_EQ(key_text("1e3"), "\"1e3\"");
  EXPECT_EQ(key_text("a: b"), "\"a: b\"");
  EXPECT_EQ(key_text("a\n\"b"), "\"a\\x0a\\\"b\"");
}

TEST(QuotedText, KeepsUtf8AndReplacesWhatIsNone) {
  EXPECT_EQ(quoted_text("b\xC3\xBCro"), "\"b\xC3\xBCro\"");
  EXPECT_EQ(quoted_text("b\xFCro"), "\"b\xEF\xBF\xBDro\"");
  EXPECT_EQ(quoted_text("\xC3"), "\"\xEF\xBF\xBD\"");
  EXPECT_EQ(key_text("b\xFCro"), "\"b\xEF\xBF\xBDro\"");
}

TEST(UtcText, IsADateWithMilliseconds) {
  EXPECT_EQ(utc_text(1'790'000'000'512'999'999), "2026-09-21 14:13:20.512");
  EXPECT_EQ(utc_text(0), "1970-01-01 00:00:00.000");
  EXPECT_EQ(utc_text(-1), "1969-12-31 23:59:59.999");
}

}  // namespace
}  // namespace rigcal
