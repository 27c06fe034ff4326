#include "core/report/svg_plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tinyxml.h>

#include <functional>
#include <limits>

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// All elements of a kind, whatever they are in.
std::vector<const TiXmlElement*> elements(const TiXmlElement* root, const std::string& kind) {
  std::vector<const TiXmlElement*> found;
  const std::function<void(const TiXmlElement*)> walk = [&](const TiXmlElement* at) {
    if (kind == at->Value()) found.push_back(at);
    for (const TiXmlElement* child = at->FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
      walk(child);
    }
  };
  walk(root);
  return found;
}

double number(const TiXmlElement* element, const char* name) {
  double value = std::numeric_limits<double>::quiet_NaN();
  element->QueryDoubleAttribute(name, &value);
  return value;
}

class Plot : public testing::Test {
 protected:
  const TiXmlElement* parsed(const SvgPlot& plot) {
    document.Parse(plot.svg().c_str());
    EXPECT_FALSE(document.Error()) << document.ErrorDesc() << " in " << plot.svg();
    return document.RootElement();
  }
  TiXmlDocument document;
};

TEST(Ticks, AreRoundNumbers) {
  EXPECT_THAT(linear_ticks(0.0, 10.0, 5), ElementsAre(0.0, 2.0, 4.0, 6.0, 8.0, 10.0));
  EXPECT_THAT(linear_ticks(-0.3, 0.31, 4),
              ElementsAre(testing::DoubleNear(-0.2, 1e-12), 0.0, testing::DoubleNear(0.2, 1e-12)));
  EXPECT_THAT(linear_ticks(3.0, 3.0, 5), ElementsAre(3.0));
  EXPECT_THAT(log_ticks(0.5, 20.0), ElementsAre(0.5, 1.0, 2.0, 5.0, 10.0, 20.0));
  EXPECT_THAT(log_ticks(1.0, 1e6), ElementsAre(1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6));
  EXPECT_LT(log_ticks(1e-30, 1e30).size(), 12U);
  EXPECT_THAT(log_ticks(0.0, 1.0), ElementsAre(0.0));
}

TEST_F(Plot, PutsLinesWhereTheAxesSay) {
  SvgPlot plot(400, 300, {"time, s", 0.0, 10.0}, {"cost", 1.0, 1000.0, true}, "Cost");
  plot.line({{0.0, 1.0}, {10.0, 1000.0}, {5.0, 31.6227766}}, 2);
  const TiXmlElement* root = parsed(plot);
  const auto lines = elements(root, "polyline");
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_STREQ(lines[0]->Attribute("class"), "plot-line s2");
  // From the lower left corner to the upper right one, then to the middle.
  double x[3];
  double y[3];
  ASSERT_EQ(std::sscanf(lines[0]->Attribute("points"), "%lf,%lf %lf,%lf %lf,%lf", x, y, x + 1, y + 1, x + 2, y + 2), 6);
  EXPECT_LT(x[0], x[1]);
  EXPECT_GT(y[0], y[1]);
  EXPECT_NEAR(x[2], 0.5 * (x[0] + x[1]), 0.11);
  EXPECT_NEAR(y[2], 0.5 * (y[0] + y[1]), 0.11);
  for (const TiXmlElement* text : elements(root, "text")) {
    EXPECT_GE(number(text, "x"), 0.0);
    EXPECT_LE(number(text, "x"), 400.0);
    EXPECT_GE(number(text, "y"), 0.0);
    EXPECT_LE(number(text, "y"), 300.0);
  }
}

TEST_F(Plot, DrawsBarsInTheRowsOfTheirCategoriesAsLongAsTheirValues) {
  SvgPlot plot(600, 200, {"mm", 0.0, 10.0}, {"", 0.0, 1.0, false, {"first", "second"}}, "Bars");
  plot.bar(0, 0, 1, 5.0, 0, "five");
  plot.bar(1, 0, 1, 10.0, 0, "ten");
  plot.bar(1, 0, 1, 1e300, 0, "too much");
  const auto boxes = elements(parsed(plot), "rect");
  ASSERT_EQ(boxes.size(), 3U);
  EXPECT_NEAR(2.0 * number(boxes[0], "width"), number(boxes[1], "width"), 0.2);
  EXPECT_NEAR(number(boxes[2], "width"), number(boxes[1], "width"), 0.11);
  EXPECT_LT(number(boxes[0], "y") + number(boxes[0], "height"), number(boxes[1], "y"));
  EXPECT_STREQ(boxes[1]->FirstChildElement("title")->GetText(), "ten");
}

TEST_F(Plot, ShowsNamesFromOutsideAsTheyAre) {
  const std::string evil = "<script>alert(\"1\")</script> & 'x'";
  SvgPlot plot(600, 200, {evil, 0.0, 1.0}, {"", 0.0, 1.0, false, {evil}}, evil);
  plot.box({0.0, 0.0}, {1.0, 1.0}, 0, evil);
  plot.legend(evil, 1);
  EXPECT_THAT(plot.svg(), Not(HasSubstr("<script")));
  const TiXmlElement* root = parsed(plot);
  EXPECT_STREQ(root->Attribute("aria-label"), evil.c_str());
  EXPECT_STREQ(elements(root, "title")[0]->GetText(), evil.c_str());
}

TEST_F(Plot, SurvivesNumbersThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  SvgPlot plot(600, 200, {"", 0.0, nan}, {"", 1.0, std::numeric_limits<double>::infinity(), true}, "");
  plot.line({{nan, nan}, {0.0, 1e308}}, 0);
  plot.bar(0, 0, 1, nan, 0, "");
  parsed(plot);
}

}  // namespace
}  // namespace rigcal
