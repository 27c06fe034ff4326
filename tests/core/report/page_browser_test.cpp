// report.html in a real browser: Chromium without a screen, its graphics in software. Skipped where there is none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>

#include "core/base/random.h"
#include "core/io/jpeg_file.h"
#include "core/report/html/page.h"
#include "tests/support/headless_browser.h"
#include "tests/support/json.h"
#include "tests/support/make_result.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// A yard with a floor and four walls, a point every few centimetres, as thick as ranges are noisy.
std::vector<MapPoint> make_map(std::size_t points, double shift_m) {
  Random random(7);
  std::vector<MapPoint> map;
  for (std::size_t i = 0; i < points; ++i) {
    const double u = 40.0 * random.uniform() - 20.0;
    const double v = 30.0 * random.uniform() - 15.0;
    const double off = 0.01 * random.normal();
    const auto sensor = static_cast<std::uint8_t>(i % 4);
    const double moved = sensor == 0 ? 0.0 : shift_m;
    Vector3d p(u, v, -1.2 + off);
    if (i % 3 == 1) p = {i % 2 == 0 ? -20.0 + off + moved : 20.0 + off + moved, v, 4.0 * random.uniform() - 1.2};
    if (i % 3 == 2) p = {u, i % 2 == 0 ? -15.0 + off + moved : 15.0 + off + moved, 4.0 * random.uniform() - 1.2};
    map.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()),
                   static_cast<std::uint8_t>(i % 200), sensor});
  }
  return map;
}

std::vector<std::uint8_t> noisy_jpeg(std::uint64_t seed) {
  Random random(seed);
  Image image;
  image.width = 1280;
  image.height = 1050;
  image.channels = 3;
  image.bytes.resize(image.row_bytes() * static_cast<std::size_t>(image.height));
  for (std::size_t i = 0; i < image.bytes.size(); ++i) {
    image.bytes[i] = static_cast<std::uint8_t>(100 + (i / 3840) % 60 + 40 * random.uniform());
  }
  return *encode_jpeg(image, 85);
}

Rig make_rig(int cameras) {
  Rig rig;
  rig.name = "yard";
  for (const char* name : {"avia", "mid100_left", "mid100_middle", "mid100_right"}) {
    Sensor sensor;
    sensor.name = name;
    sensor.lidar.emplace();
    sensor.lidar->model = rig.sensors.empty() ? LidarModel::livox_avia : LidarModel::livox_mid40;
    rig.sensors.push_back(sensor);
  }
  for (int i = 0; i < cameras; ++i) {
    Sensor sensor;
    sensor.name = "camera_" + std::to_string(i);
    sensor.camera.emplace();
    sensor.camera->intrinsics =
        CameraIntrinsics{DistortionModel::radtan, 1280, 1024, 863.0, 863.0, 639.5, 511.5, {-0.1, 0.09, 0, 0, 0}};
    rig.sensors.push_back(sensor);
  }
  return rig;
}

// As large as a run of so many stops and cameras gives.
CalibrationResult make_large_result(const Rig& rig, int stops, int overlays_a_camera) {
  CalibrationResult result = make_result();
  result.status = Status::weak;
  result.sensors.clear();
  result.trajectory.clear();
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    SensorResult sensor;
    sensor.name = rig.sensors[i].name;
    sensor.status = i == 2 ? Status::weak : Status::good;
    if (i == 2) sensor.reasons = {"its translation is known to 14 mm only (95 %, asked for: 10.0 mm)"};
    Vector6d xi;
    xi << 0.1, 0.2, 0.5 * static_cast<double>(i), 0.1, 0.2, -0.1;
    sensor.T_base_sensor = i == 0 ? SE3{} : SE3::exp(xi);
    sensor.guess_T_base_sensor = sensor.T_base_sensor;
    sensor.covariance = 1e-8 * Matrix6d::Identity();
    sensor.hold_out = {1.0 + 0.1 * static_cast<double>(i), 0.004, 0.3, rig.sensors[i].is_lidar() ? "m" : "px"};
    result.sensors.push_back(sensor);
  }
  for (int j = 0; j < stops; ++j) {
    StopPose pose;
    pose.stop = {j, 4'000'000'000LL * j, 4'000'000'000LL * j + 2'000'000'000LL};
    for (const Sensor& sensor : rig.sensors) pose.points[sensor.name] = 200'000 - 1000 * static_cast<std::uint64_t>(j);
    result.trajectory.push_back(pose);
  }
  for (const Sensor& sensor : rig.sensors) {
    if (sensor.is_lidar()) continue;
    for (int k = 0; k < overlays_a_camera; ++k) {
      result.overlays.push_back({sensor.name, k, k == 3 ? OverlayKind::map : OverlayKind::edges, noisy_jpeg(5)});
    }
  }
  result.stages[0].costs = {{100.0, 40.0, 20.0}, {30.0, 12.0, 11.9}};
  result.shared_surfaces = {{"avia", "mid100_left", 900, 0.3, 0.002}, {"", "", 900, 0.3, 0.002}};
  SurfaceCut cut;
  cut.half_length_m = 0.75;
  cut.half_depth_m = 0.4;
  for (int k = 0; k < 4000; ++k) {
    const float along = -0.75F + 1.5F * static_cast<float>(k) / 4000.0F;
    cut.before.push_back({along, k % 2 == 0 ? 0.0F : 0.3F, static_cast<std::uint8_t>(k % 2)});
    cut.after.push_back({along, 0.002F * static_cast<float>(k % 7), static_cast<std::uint8_t>(k % 2)});
  }
  result.cuts = {cut, cut, cut};
  result.map = make_map(1'000'000, 0.0);
  result.map_at_guess = make_map(300'000, 0.4);
  return result;
}

class PageInBrowser : public testing::Test {
 protected:
  void SetUp() override {
    root = scratch_folder("page");
    browser = HeadlessBrowser::find(root);
    if (!browser) GTEST_SKIP() << HeadlessBrowser::missing;
  }

  [[nodiscard]] Json seen(const std::string& page, int width = 1300, int height = 1000) const {
    return browser->seen(page, width, height);
  }
  static void expect_whole(const Json& seen, std::size_t pictures) {
    ASSERT_TRUE(seen.value("done", false)) << json_text(seen);
    EXPECT_EQ(json_text(seen["problems"]), "[]");
    EXPECT_LE(seen["wide_px"].get<int>(), 0);
    EXPECT_EQ(seen["pictures"].size(), pictures);
    for (const Json& content : seen["pictures"]) EXPECT_GT(content.get<double>(), 0.005);
  }

  fs::path root;
  std::optional<HeadlessBrowser> browser;
};

TEST_F(PageInBrowser, ShowsEverythingAndTurnsTheView) {
  const Rig rig = make_rig(2);
  const std::string page = report_html(make_large_result(rig, 20, 4), &rig);
  EXPECT_LT(page.size(), 20'000'000U);
  const Json wide = seen(page);
  expect_whole(wide, 8 + 4 + 9);
  EXPECT_GT(wide["view_filled"].get<double>(), 0.02);
  EXPECT_GT(wide["view_turned"].get<double>(), 0.02);
  for (const auto& [name, filled] : wide["views"].items()) EXPECT_GT(filled.get<double>(), 0.005) << name;
  EXPECT_EQ(wide["views"].size(), 6U);
  EXPECT_GE(wide["plots"].get<int>(), 4 + 9 + 4);
  // Told, not asked for: how long it takes is the machine's.
  std::printf("%zu bytes, loaded in %.0f ms\n", page.size(), wide["load_ms"].get<double>());
}

TEST_F(PageInBrowser, FitsAPhone) {
  const Rig rig = make_rig(2);
  expect_whole(seen(report_html(make_large_result(rig, 20, 1), &rig), 390, 844), 2 + 4 + 9);
}

TEST_F(PageInBrowser, ShowsLongRunsOfManyCameras) {
  const Rig rig = make_rig(6);
  const std::string page = report_html(make_large_result(rig, 60, 4), &rig);
  EXPECT_LT(page.size(), 20'000'000U);
  const Json wide = seen(page);
  expect_whole(wide, 24 + 4 + 9);
  std::printf("%zu bytes, loaded in %.0f ms\n", page.size(), wide["load_ms"].get<double>());
}

TEST_F(PageInBrowser, ShowsRunsWithoutCamerasAndOfOneStop) {
  const Rig rig = make_rig(0);
  for (const int stops : {20, 1}) {
    CalibrationResult result = make_large_result(rig, stops, 0);
    result.map.resize(150'000);
    result.map_at_guess.resize(100'000);
    const Json wide = seen(report_html(result, &rig));
    expect_whole(wide, 4 + 9);
    EXPECT_GT(wide["view_filled"].get<double>(), 0.02);
  }
}

// What somebody who never saw rigcal must find without scrolling: the verdict, the sensor, the reason.
struct Prepared {
  const char* what;
  int sensor;  ///< Of the rig; -1: none is at fault.
  Status status;
  const char* reason;   ///< Of the sensor.
  const char* warning;  ///< Of the run.
  const char* verdict;
};

TEST_F(PageInBrowser, TellsAStrangerOnTheFirstScreen) {
  const Rig rig = make_rig(2);
  const Prepared prepared[]{
      {"good", -1, Status::good, "", "", "All 6 sensors are good."},
      {"one camera wrong", 4, Status::failed, "it fits held-out images worse (9.1 px) than its start did (4.0 px)", "",
       "5 of 6 sensors are good: camera_0 failed."},
      {"one LiDAR degenerate along z", 2, Status::weak,
       "its translation is known to 48.0 mm only (95 %, asked for: 10.0 mm), worst along (0.00, 0.00, 1.00) of the "
       "base "
       "frame; add stops that see a surface facing that way",
       "", "5 of 6 sensors are good: mid100_middle is weak."},
      {"a lossy recording", -1, Status::good, "", "mid100_left: 4.1 % of its point packets are lost",
       "All 6 sensors are good."},
      {"bad clock", 3, Status::weak, "its clock jumped 3 times: what it saw then may be in the wrong stop",
       "mid100_right: its clock was set 3 times during the recording",
       "5 of 6 sensors are good: mid100_right is weak."}};
  for (const Prepared& p : prepared) {
    CalibrationResult result = make_large_result(rig, 20, 0);
    result.map.resize(5000);
    result.map_at_guess.clear();
    result.status = p.status;
    for (SensorResult& sensor : result.sensors) {
      sensor.status = Status::good;
      sensor.reasons.clear();
    }
    if (p.sensor >= 0) {
      SensorResult& sensor = result.sensors[static_cast<std::size_t>(p.sensor)];
      sensor.status = p.status;
      sensor.reasons = {p.reason};
      if (p.status == Status::failed) sensor.T_base_sensor.reset();
    }
    result.warnings.clear();
    if (*p.warning != '\0') result.warnings = {p.warning};
    const Json page = browser->seen(report_html(result, &rig), 1280, 800, false);
    const std::string screen = page.value("first_screen", "");
    EXPECT_THAT(screen, testing::HasSubstr(std::string(to_string(p.status)) + " " + p.verdict)) << p.what;
    EXPECT_THAT(screen, testing::HasSubstr(p.reason)) << p.what;
    EXPECT_THAT(screen, testing::HasSubstr(p.warning)) << p.what;
    if (p.sensor >= 0) {
      EXPECT_THAT(screen, testing::HasSubstr(rig.sensors[static_cast<std::size_t>(p.sensor)].name)) << p.what;
    }
  }
}

TEST_F(PageInBrowser, ShowsFailures) {
  CalibrationResult result = make_result();
  result.map.clear();
  expect_whole(seen(report_html(result, nullptr)), 0);
}

}  // namespace
}  // namespace rigcal
