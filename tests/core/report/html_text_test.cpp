#include "core/report/html_text.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

std::string base64_of(std::string_view text) {
  return base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

TEST(HtmlText, EscapesWhatHasAMeaning) {
  EXPECT_EQ(html_text("a<b>&\"c\"'"), "a&lt;b&gt;&amp;&quot;c&quot;&#39;");
  EXPECT_EQ(html_text("Gerät 3,\n日本 😀"), "Gerät 3,\n日本 😀");
}

TEST(HtmlText, ReplacesWhatIsNoText) {
  const std::string hole = "\xEF\xBF\xBD";
  EXPECT_EQ(html_text(std::string_view("a\0b\x1B"
                                       "c\x7F",
                                       6)),
            "a" + hole + "b" + hole + "c" + hole);
  // A lone tail, a cut character, a slash in two bytes, a surrogate, beyond the last character.
  EXPECT_EQ(html_text("\x80"), hole);
  EXPECT_EQ(html_text("x\xE2\x82"), "x" + hole + hole);
  EXPECT_EQ(html_text("\xC0\xAF"), hole + hole);
  EXPECT_EQ(html_text("\xED\xA0\x80"), hole + hole + hole);
  EXPECT_EQ(html_text("\xF4\x90\x80\x80"), hole + hole + hole + hole);
  EXPECT_EQ(html_text("\xE2<"), hole + "&lt;");
}

// RFC 4648, section 10.
TEST(Base64, GivesThePublishedTexts) {
  EXPECT_EQ(base64_of(""), "");
  EXPECT_EQ(base64_of("f"), "Zg==");
  EXPECT_EQ(base64_of("fo"), "Zm8=");
  EXPECT_EQ(base64_of("foo"), "Zm9v");
  EXPECT_EQ(base64_of("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64_of("\xFB\xFF"), "+/8=");
}

}  // namespace
}  // namespace rigcal
