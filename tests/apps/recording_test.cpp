#include "apps/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/io/image_file.h"
#include "core/io/tum_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

// A LiDAR's clouds at stops 3 and 4, a camera's images at stops 3, 5 and 9.
class RecordingOfPatches : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "patches" / "top");
    fs::create_directories(folder_ / "patches" / "image" / "eye");
    for (const char* stop : {"3", "4"}) {
      std::ofstream(folder_ / "patches" / "top" / (std::string(stop) + ".pcd"))
          << "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 "
             "0\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n";
    }
    const Image image{2, 2, 1, 8, {}, {1, 2, 3, 4}};
    for (const char* stop : {"3", "5", "9"}) {
      ASSERT_TRUE(write_image((folder_ / "patches" / "image" / "eye" / (std::string(stop) + ".png")).string(), image));
    }
    std::ofstream(folder_ / "rig.yaml")
        << "rigcal: 1\nname: small\nbase: top\nsensors:\n  top: {type: lidar}\n  eye: {type: camera, driver: images}\n";
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write_trajectory(double metres_a_stop) const {
    std::vector<TumPose> poses;
    for (const int stop : {3, 4, 5, 7})
      poses.push_back(
          {stop * std::int64_t{1'000'000'000}, SE3{Matrix3d::Identity(), {metres_a_stop * stop, 0.0, 0.0}}});
    ASSERT_TRUE(write_tum((folder_ / "patches" / "trajectory.tum").string(), poses));
  }
  [[nodiscard]] Expected<Recording> read() const {
    SilentReporter silent;
    return read_recording({(folder_ / "patches").string(), (folder_ / "rig.yaml").string(), {}}, CellOptions{},
                          RunContext{silent});
  }
  static std::vector<int> stops(const Recording& recording) {
    std::vector<int> out;
    for (const Stop& stop : recording.lidar.stops) out.push_back(stop.index);
    return out;
  }

  fs::path folder_;
};

TEST_F(RecordingOfPatches, HasStopsOfImagesAloneWhereTheirPosesAreGiven) {
  write_trajectory(0.1);
  const auto recording = read();
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_THAT(stops(*recording), ElementsAre(3, 4, 5)) << "9 has no pose, 7 no image";
  ASSERT_EQ(recording->lidar.trajectory.size(), 3U);
  EXPECT_NEAR(recording->lidar.trajectory[2]->t.x(), 0.5, 1e-9);
  ASSERT_EQ(recording->lidar.patches.size(), 2U);
  EXPECT_EQ(recording->lidar.patches[1].stop, 1);
}

TEST_F(RecordingOfPatches, HasNoStopOfImagesAloneWithoutAPose) {
  auto recording = read();
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_THAT(stops(*recording), ElementsAre(3, 4));
  // The gyro's rotations do not say where the rig was.
  write_trajectory(0.0);
  recording = read();
  ASSERT_TRUE(recording) << recording.error().message();
  EXPECT_THAT(stops(*recording), ElementsAre(3, 4));
}

}  // namespace
}  // namespace rigcal
