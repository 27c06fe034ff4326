#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "apps/recording/recording.h"
#include "core/base/random.h"
#include "tests/support/json.h"
#include "tests/support/real_recordings.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::AnyOf;
using testing::HasSubstr;

using RowMajor34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

struct RoadScene {
  std::string name;
  std::string cloud;
  std::string image;
  CameraIntrinsics intrinsics;
  SE3 T_camera_lidar;  ///< The project's own: right to half a degree in scene a, where lanes lie 10 px beside the
                       ///< paint.
};

SE3 pose_of(const std::vector<double>& v) {
  const RowMajor34 T = Eigen::Map<const RowMajor34>(v.data());
  return {T.leftCols<3>(), T.col(3)};
}

CameraIntrinsics camera_of(const std::array<double, 4>& focal_and_centre, const std::vector<double>& d) {
  const auto& [fx, fy, cx, cy] = focal_and_centre;
  return {DistortionModel::radtan, 1920, 1200, fx, fy, cx, cy, {d[0], d[1], d[2], d[3], 0.0}};
}

// "K: ..." "D: ..." "T: ...", a line each.
RoadScene scene_a(const fs::path& folder) {
  std::ifstream in(folder / "calib.txt");
  std::map<std::string, std::vector<double>> lists;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line.substr(line.find(':') + 1));
    for (double x = 0.0; words >> x;) lists[line.substr(0, 1)].push_back(x);
  }
  const std::vector<double>& K = lists.at("K");
  return {"scene_a", "calib.pcd", "calib.jpg", camera_of({K[0], K[4], K[2], K[5]}, lists.at("D")),
          pose_of(lists.at("T"))};
}

RoadScene scene_b(const fs::path& folder) {
  const auto camera = json_of_file(folder / "center_camera-intrinsic.json").at("center_camera-intrinsic").at("param");
  const auto K = camera.at("cam_K").at("data");
  const std::vector<double> d = camera.at("cam_dist").at("data").at(0);
  const std::string name = "top_center_lidar-to-center_camera-extrinsic";
  const auto rows = json_of_file(folder / (name + ".json")).at(name).at("param").at("sensor_calib").at("data");
  std::vector<double> T;
  for (const auto& row : rows) {
    for (const double x : row) T.push_back(x);
  }
  return {"scene_b", "0.pcd", "0.png", camera_of({K[0][0], K[1][1], K[0][2], K[1][2]}, d), pose_of(T)};
}

// One cloud of a 64-beam LiDAR and one image: roads, trees, vehicles, hardly a wall.
class RealVehicleCamera : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    source_ = real_recordings() / "vehicle_lidar_camera" / GetParam();
    if (!fs::exists(source_)) GTEST_SKIP() << "no real recordings in " << source_.parent_path();
    scene_ = GetParam() == std::string("scene_a") ? scene_a(source_) : scene_b(source_);
    folder_ = scratch_folder("real_vehicle_camera");
    fs::create_directories(folder_ / "patches" / "top");
    fs::create_directories(folder_ / "patches" / "image" / "front");
    fs::copy_file(source_ / scene_.cloud, folder_ / "patches" / "top" / "0.pcd");
    fs::copy_file(source_ / scene_.image,
                  folder_ / "patches" / "image" / "front" / ("0" + fs::path(scene_.image).extension().string()));
  }

  [[nodiscard]] Expected<CalibrationResult> calibrate(const SE3& guess_T_base_camera) const {
    Rig rig;
    rig.name = "vehicle";
    rig.sensors.resize(2);
    rig.sensors[0].name = "top";
    rig.sensors[0].lidar.emplace();
    rig.sensors[1].name = "front";
    rig.sensors[1].camera.emplace();
    rig.sensors[1].camera->driver = "images";
    rig.sensors[1].camera->intrinsics = scene_.intrinsics;
    rig.sensors[1].initial_T_base_sensor = guess_T_base_camera;
    const std::string rig_path = (folder_ / "rig.yaml").string();
    std::ofstream(rig_path) << write_rig(rig);
    SilentReporter reporter;
    const RunContext context{reporter};
    CellOptions cells;
    cells.keep_thinned = true;
    const auto recording = read_recording({(folder_ / "patches").string(), rig_path, {}}, cells, context);
    if (!recording) return recording.error();
    return calibrate_rig(recording->rig, recording->lidar, recording->cameras, {SE3{}}, {}, context);
  }

  fs::path source_;
  fs::path folder_;
  RoadScene scene_;
};

TEST_P(RealVehicleCamera, IsFoundButNeverCalledGoodFromOneImage) {
  const SE3 published = scene_.T_camera_lidar.inverse();
  Random random(7);
  const auto direction = [&random] { return Vector3d(random.normal(), random.normal(), random.normal()).normalized(); };
  constexpr int starts = 12;
  std::vector<double> turns_deg;
  for (int k = 0; k < starts; ++k) {
    const SE3 off{exp_so3(to_rad(3.0) * direction()), 0.1 * direction()};
    const auto result = calibrate(published * off);
    ASSERT_TRUE(result) << result.error().message();
    const SensorResult& camera = result->sensors.back();
    ASSERT_EQ(camera.name, "front");
    // One stop: nothing can be held out, and no surface says more than the road.
    EXPECT_NE(camera.status, Status::good);
    ASSERT_FALSE(camera.reasons.empty());
    ASSERT_TRUE(camera.T_base_sensor) << scene_.name << ": " << camera.reasons.front();
    const double off_deg = to_deg(rotation_distance(camera.T_base_sensor->R, published.R));
    const double off_m = (camera.T_base_sensor->t - published.t).norm();
    turns_deg.push_back(off_deg);
    std::printf("%s start %d: %s, %.3f deg and %.0f mm from the published pose\n", scene_.name.c_str(), k,
                to_string(camera.status), off_deg, 1e3 * off_m);
    for (const std::string& reason : camera.reasons) std::printf("    %s\n", reason.c_str());
    // What is a false match says first that it may be one.
    if (off_deg > 1.0) {
      EXPECT_THAT(camera.reasons.front(), AnyOf(HasSubstr("disagree"), HasSubstr("another pose")));
    }
    if (scene_.name == "scene_a") continue;
    EXPECT_LT(off_deg, 0.5);
    EXPECT_LT(off_m, 0.2);
  }
  // Few edges are in scene a: from some starts it is another place that explains them.
  std::sort(turns_deg.begin(), turns_deg.end());
  EXPECT_LT(turns_deg[starts / 2], scene_.name == "scene_a" ? 1.0 : 0.3);
}

INSTANTIATE_TEST_SUITE_P(Scenes, RealVehicleCamera, ::testing::Values("scene_a", "scene_b"));

}  // namespace
}  // namespace rigcal
