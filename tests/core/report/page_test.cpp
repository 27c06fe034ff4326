#include "core/report/html/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/report/html/field_of_view.h"
#include "core/report/html/resources.h"
#include "core/report/summary_text.h"
#include "tests/support/make_result.h"

namespace rigcal {
namespace {

using testing::HasSubstr;
using testing::Not;

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

// The page without the program text in it.
std::string body(std::string page) {
  for (const std::string_view part : {html::three_js, html::orbit_controls_js, html::view3d_js, html::page_css}) {
    const std::size_t at = page.find(part);
    EXPECT_NE(at, std::string::npos);
    page.erase(at, part.size());
  }
  return page;
}

// The bytes behind the coordinates of the first point of the 3-D view, as the page carries them.
std::vector<std::uint8_t> first_colour(const std::string& page) {
  const std::string mark = "id=\"points\">";
  const std::size_t at = page.rfind(mark) + mark.size();
  std::vector<std::uint8_t> out;
  // 4 letters are 3 bytes; a point has 10 and its colour begins at the 7th, so at the 9th letter.
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::uint32_t bits = 0;
  for (std::size_t k = 8; k < 12; ++k) bits = bits << 6U | static_cast<std::uint32_t>(letters.find(page[at + k]));
  for (const unsigned shift : {16U, 8U, 0U}) out.push_back(static_cast<std::uint8_t>(bits >> shift & 0xFFU));
  return out;
}

TEST(Page, ShowsTheMapInTheColoursThatTheCamerasSaw) {
  CalibrationResult result = make_result();
  result.map = {{0.0F, 0.0F, 0.0F, 200, 0}, {0.1F, 0.1F, 0.1F, 7, 1}};
  EXPECT_EQ(first_colour(report_html(result, nullptr)), (std::vector<std::uint8_t>{200, 200, 200}));
  result.map_rgb = {{10, 20, 30}, {40, 50, 60}};
  EXPECT_EQ(first_colour(report_html(result, nullptr)), (std::vector<std::uint8_t>{10, 20, 30}));
}

TEST(Page, SaysFirstWhatIsWrongWithWhichSensor) {
  const CalibrationResult result = make_result();
  const std::string page = body(report_html(result, nullptr));
  const std::size_t numbers = page.find("<section");
  EXPECT_LT(page.find("1 of 3 sensors is good: mid40_left is weak, mid40_right failed."), numbers);
  EXPECT_LT(page.find("<h3>mid40_right</h3>"), page.find("<h3>mid40_left</h3>"));
  EXPECT_LT(page.find("<h3>mid40_left</h3>"), page.find("<h3>avia</h3>"));
  EXPECT_LT(page.find("height is not fixed: no &quot;floor&quot; was seen"), numbers);
  EXPECT_LT(page.find("no stop connects it with the base"), numbers);
  EXPECT_LT(page.find("a packet is damaged"), numbers);
}

TEST(Page, SaysWhatIsWrongWithTheRecordingOfASensorOnceAndBeforeWhatIsWell) {
  CalibrationResult result = make_result();
  result.status = Status::good;
  for (SensorResult& sensor : result.sensors) {
    sensor.status = Status::good;
    sensor.reasons.clear();
  }
  result.sensors[2].T_base_sensor = SE3{};
  result.packets["mid40_right"] = {
      {"point_expected", 1000}, {"point_received", 969}, {"point_lost", 31}, {"point_gaps", 30}};
  ClockReport clock{"mid40_left", 1.0, 2.0, 3.0, 2, 0};
  result.clocks = {clock};
  const std::string loss = "3.1 % of its point packets are lost (31 in 30 gaps)";
  result.warnings = {"mid40_right: " + loss + "; check cable and switch, and the receive buffer (rigcal doctor)",
                     "stop 7 is left out"};
  const std::string page = body(report_html(result, nullptr));
  EXPECT_THAT(page, HasSubstr("But the recording has faults: packets lost (mid40_right); clock (mid40_left)."));
  EXPECT_EQ(count(page, loss), 1U);
  EXPECT_EQ(count(page, "its clock jumped twice"), 1U);
  EXPECT_LT(page.find("<h3>mid40_right</h3>"), page.find("stop 7 is left out"));
  EXPECT_LT(page.find("stop 7 is left out"), page.find("<h3>avia</h3>"));
  result.status = Status::weak;
  EXPECT_THAT(report_html(result, nullptr), HasSubstr("The recording has faults, too: packets lost (mid40_right)"));
  result.packets.clear();
  result.clocks.clear();
  EXPECT_THAT(report_html(result, nullptr), Not(HasSubstr("has faults")));
}

TEST(Page, JudgesNoIntrinsicsByImagesOfTooFewStops) {
  CalibrationResult result = make_result();
  CameraEvidence camera;
  camera.name = "front";
  camera.images.push_back({0, "front/0.png"});
  camera.estimate.found = true;
  camera.estimate.k1_change = {0.0123, 0.001};
  camera.estimate.focal_scale = {0.001, 0.0005};
  result.cameras.push_back(camera);
  EXPECT_THAT(body(report_html(result, nullptr)), AllOf(HasSubstr("0.0123"), Not(HasSubstr("too few stops to tell"))));
  result.cameras[0].estimate.k1_change = result.cameras[0].estimate.focal_scale = {};
  EXPECT_THAT(body(report_html(result, nullptr)), HasSubstr("too few stops to tell"));
}

TEST(Page, HoldsNothingFromElsewhereAndRunsNothingOfANames) {
  CalibrationResult result = make_result();
  const std::string evil = "</script><script>alert(1)</script>\"'<img src=x onerror=alert(1)>";
  result.sensors[1].name = evil;
  result.warnings = {evil};
  result.settings = {{evil, evil}};
  result.trajectory[0].points[evil] = 5;
  result.sensors[1].hold_out = {1.5, 0.01, 0.2, "m"};
  result.shared_surfaces = {{"avia", evil, 7, 0.1, 0.01}, {"", "", 7, 0.1, 0.01}};
  result.stages[0].name = evil;
  result.stages[0].costs = {{12.0, 3.0}};
  result.clocks = {{evil, 1.0, 2.0, 3.0, 0, 0}};
  result.inputs = {{evil, 1, 10, evil, false}};
  result.packets[evil]["point_expected"] = 3;
  result.overlays = {{evil, 0, OverlayKind::edges, {1, 2, 3}}};
  Rig rig;
  rig.name = evil;
  rig.sensors.resize(3);
  rig.sensors[1].name = evil;
  rig.sensors[1].lidar.emplace();
  for (const Rig* known : {static_cast<const Rig*>(nullptr), static_cast<const Rig*>(&rig)}) {
    const std::string page = report_html(result, known);
    EXPECT_EQ(page.find("<img src=x"), std::string::npos);
    EXPECT_EQ(count(page, "alert(1)</script>"), 0U);
    const std::string own = body(page);
    // Scene, points, and the three programs.
    EXPECT_EQ(count(own, "<script"), 5U);
    EXPECT_EQ(count(own, "</script"), 5U);
    for (const char* from_elsewhere : {"src=\"http", "href=\"http", "url(http", "@import"}) {
      EXPECT_EQ(own.find(from_elsewhere), std::string::npos) << from_elsewhere;
    }
    EXPECT_THAT(own, HasSubstr("default-src 'none'"));
  }
}

TEST(Page, IsMadeOfAnyResult) {
  // Nothing but a base; then without map, stops, stages.
  CalibrationResult result;
  result.base = "avia";
  result.method = "targetless";
  result.status = Status::good;
  result.sensors.resize(1);
  result.sensors[0].name = "avia";
  result.sensors[0].status = Status::good;
  result.sensors[0].T_base_sensor = SE3{};
  const std::string page = body(report_html(result, nullptr));
  EXPECT_THAT(page, HasSubstr("The one sensor is good."));
  EXPECT_THAT(page, Not(HasSubstr("id=\"view3d\"")));
  EXPECT_THAT(page, HasSubstr("</html>"));
}

TEST(Page, KeepsToItsBudgetWhateverTheMap) {
  CalibrationResult result = make_result();
  result.map.clear();
  for (int i = 0; i < 2'000'000; ++i) {
    const auto x = static_cast<float>(i % 1000) * 0.05F;
    const auto y = static_cast<float>(i / 1000) * 0.025F;
    result.map.push_back({x, y, 0.1F * static_cast<float>(i % 7), static_cast<std::uint8_t>(i), 1});
  }
  result.map_at_guess = result.map;
  const std::string page = report_html(result, nullptr);
  EXPECT_LT(page.size(), 10'000'000U);
  EXPECT_THAT(body(page), HasSubstr("300000 of 2000000 points"));
}

TEST(Page, OfTheSameResultIsTheSame) {
  EXPECT_TRUE(report_html(make_result(), nullptr) == report_html(make_result(), nullptr));
}

TEST(SummarySentence, CountsAndNames) {
  CalibrationResult result = make_result();
  EXPECT_EQ(summary_sentence(result), "1 of 3 sensors is good: mid40_left is weak, mid40_right failed.");
  for (SensorResult& sensor : result.sensors) sensor.status = Status::good;
  EXPECT_EQ(summary_sentence(result), "All 3 sensors are good.");
}

TEST(FieldOfView, IsThatOfTheDataSheetOrTheLens) {
  Sensor avia;
  avia.lidar.emplace();
  avia.lidar->model = LidarModel::livox_mid40;
  const auto round = field_of_view(avia);
  ASSERT_FALSE(round.empty());
  for (const Vector3d& ray : round) {
    EXPECT_NEAR(ray.norm(), 1.0, 1e-12);
    EXPECT_NEAR(to_deg(std::acos(ray.x())), 19.2, 0.3);
  }
  Sensor camera;
  camera.camera.emplace();
  camera.camera->intrinsics =
      CameraIntrinsics{DistortionModel::radtan, 101, 101, 50.0, 50.0, 50.0, 50.0, {0, 0, 0, 0, 0}};
  const auto square = field_of_view(camera);
  ASSERT_FALSE(square.empty());
  // A corner is 45 degrees to either side.
  EXPECT_TRUE(std::any_of(square.begin(), square.end(), [](const Vector3d& ray) {
    return (ray - Vector3d(-1.0, -1.0, 1.0).normalized()).norm() < 1e-6;
  }));
  avia.lidar->model = LidarModel::other;
  EXPECT_TRUE(field_of_view(avia).empty());
}

}  // namespace
}  // namespace rigcal
