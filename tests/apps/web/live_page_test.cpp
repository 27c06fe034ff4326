// The page of a running capture in a browser.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/web/page.h"
#include "apps/web/web_view.h"
#include "tests/support/headless_browser.h"
#include "tests/support/json.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

CaptureStatus some_status() {
  CaptureStatus status;
  status.seconds = 31.0;
  status.progress.state = CaptureState::capturing;
  status.progress.stops = 2;
  status.devices.push_back({});
  status.devices.back().sensor = "avia";
  status.devices.back().packets_per_s = 2701.0;
  status.cameras.push_back({});
  status.cameras.back().sensor = "left";
  status.cameras.back().state = "streaming";
  status.news = {"2026-11-22 14:13:20 capture: stop 2 <b>is</b> in"};
  return status;
}

LiveEstimates some_estimates() {
  LiveEstimates known;
  for (int stops = 1; stops <= 3; ++stops) {
    StopEstimate& estimate = known.estimates.emplace_back();
    estimate.stops = stops;
    estimate.lidars.resize(2);
    estimate.lidars[0].result = {"avia", Status::good, {}, SE3{}, Matrix6d::Zero()};
    estimate.lidars[1].result = {"mid40", Status::weak, {}, SE3{}, Matrix6d::Identity()};
    estimate.lidars[1].translation_bound_m = 0.02 / stops;
    estimate.lidars[1].rotation_bound_rad = to_rad(0.1) / stops;
    estimate.advice_text = "turn the table by 60 degrees";
  }
  return known;
}

// Every other direction was seen by these LiDARs, a bit for each.
std::string some_state(const std::string& rig = small_rig(), std::uint32_t seen_by = 3) {
  LiveView view;
  view.panorama.seen_by.assign(static_cast<std::size_t>(Panorama::rows) * Panorama::columns, 0);
  for (std::size_t k = 0; k < view.panorama.seen_by.size(); k += 2) view.panorama.seen_by[k] = seen_by;
  const LiveEstimates known = some_estimates();
  return web_state(*parse_rig(rig, "rig.yaml"), some_status(), &known, &view, Requirement{});
}

TEST(LivePage, StateHasTheNewestEstimatesAndSaysThatNoMoreCome) {
  LiveEstimates known;
  for (int stops = 1; stops <= 150; ++stops) known.estimates.emplace_back().stops = stops;
  known.left_out = 1;
  const auto state =
      parse_json(web_state(*parse_rig(small_rig(), "rig.yaml"), some_status(), &known, nullptr, Requirement{}));
  ASSERT_EQ(state["estimates"].size(), 100U);
  EXPECT_EQ(state["estimates"][99]["stops"], 150);
  EXPECT_THAT(state["advice"].get<std::string>(), HasSubstr("no further stops are solved as it goes"));
}

// With LiDARs behind the two of the small rig.
std::string rig_of(int lidars) {
  std::string more;
  for (int i = 3; i <= lidars; ++i) more += "  lidar" + std::to_string(i) + ": {type: livox_mid40}\n";
  return small_rig(more);
}

TEST(LivePage, StateHasAllThatThePageShows) {
  const std::string text = some_state();
  EXPECT_EQ(text.find('\n'), std::string::npos);
  const auto state = parse_json(text);
  EXPECT_EQ(state["state"], "capturing");
  EXPECT_EQ(state["estimates"].size(), 3U);
  EXPECT_EQ(state["panorama"]["cells"].get<std::string>().size(), std::size_t{Panorama::rows} * Panorama::columns);
  EXPECT_THAT(state["advice"].get<std::string>(), HasSubstr("turn the table by 60 degrees"));
  const auto bare =
      parse_json(web_state(*parse_rig(small_rig(), "rig.yaml"), some_status(), nullptr, nullptr, Requirement{}));
  EXPECT_TRUE(bare["estimates"].empty());
  EXPECT_TRUE(bare["panorama"].is_null());
}

TEST(LivePage, StateHasAllLidarsOfThePanorama) {
  const auto few = parse_json(some_state(rig_of(4), 0b1001));
  EXPECT_EQ(few["panorama"]["cells"].get<std::string>().substr(0, 4), "9090");
  const auto many = parse_json(some_state(rig_of(32), 0x8000'0201U));
  EXPECT_EQ(many["panorama"]["lidars"].size(), 32U);
  EXPECT_EQ(many["panorama"]["cells"].get<std::string>().substr(0, 16), "8000020100000000");
}

CalibrationResult some_result() {
  CalibrationResult result;
  result.status = Status::weak;
  result.sensors = {{"avia", Status::good, {}, SE3{}, Matrix6d::Zero()},
                    {"left", Status::weak, {}, SE3{}, 1e-6 * Matrix6d::Identity()}};
  result.overlays = {
      {"left", 0, OverlayKind::map, {1}}, {"left", 0, OverlayKind::edges, {2}}, {"left", 1, OverlayKind::edges, {3}}};
  return result;
}

TEST(LivePage, TheEndHasTheResultsNumbersAndPictures) {
  const WebResult result = web_result(some_result());
  EXPECT_EQ(result.pictures.at("left"), std::vector<std::uint8_t>{2});
  const LiveEstimates known = some_estimates();
  const auto state = parse_json(
      web_state(*parse_rig(small_rig(), "rig.yaml"), some_status(), &known, nullptr, Requirement{}, &result));
  EXPECT_EQ(state["advice"], "The extrinsics stand: weak");
  ASSERT_EQ(state["result"]["sensors"].size(), 2U);
  EXPECT_EQ(state["result"]["sensors"][0]["translation_bound_mm"], 0.0);
  EXPECT_GT(state["result"]["sensors"][1]["translation_bound_mm"], 1.0);
  EXPECT_EQ(state["cameras"][0]["picture"], 1);  // Another one than before.
  EXPECT_EQ(parse_json(some_state())["cameras"][0]["picture"], 0);
}

TEST(LivePage, ShowsItInABrowser) {
  const auto scratch = scratch_folder("live_page");
  const auto browser = HeadlessBrowser::find(scratch);
  if (!browser) GTEST_SKIP() << HeadlessBrowser::missing;
  const auto server = WebServer::start({"127.0.0.1", 0}, "feed", web::page_html());
  ASSERT_TRUE(server) << server.error().message();
  (*server)->publish(some_state());
  const std::string page = browser->dom_of((*server)->url() + "#once", 2000);
  EXPECT_THAT(page, HasSubstr("<span id=\"state\">capturing</span>"));
  EXPECT_THAT(page, HasSubstr("turn the table by 60 degrees"));
  EXPECT_THAT(page, HasSubstr("<td>mid40</td><td class=\"weak\">weak</td><td>6.7</td>"));
  EXPECT_THAT(page, HasSubstr("<polyline points="));
  EXPECT_THAT(page, HasSubstr("50 % of all directions seen, 50 % by more than one LiDAR: avia, mid40"));
  EXPECT_THAT(page, HasSubstr("stop 2 &lt;b&gt;is&lt;/b&gt; in"));
  EXPECT_THAT(page, HasSubstr("<td>left</td><td>streaming</td>"));
  // The first and the last of 32 LiDARs, by their names, share what was seen.
  (*server)->publish(some_state(rig_of(32), 0x8000'0001U));
  EXPECT_THAT(browser->dom_of((*server)->url() + "#once", 2000),
              HasSubstr("50 % of all directions seen, 50 % by more than one LiDAR: avia, lidar10, lidar11"));
}

}  // namespace
}  // namespace rigcal
