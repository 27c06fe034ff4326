#pragma once

#include <gtest/gtest.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/pcd_file.h"
#include "core/rig/rig.h"
#include "tests/support/cloud_distance.h"
#include "tests/support/files.h"
#include "tests/support/real_recordings.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {

// Two clouds of a real MID-100 (middle unit at stop 10, right unit at stop 12) with the published poses and extrinsics;
// the base (an AVIA) was not published.
class RealMid100 : public ::testing::Test {
 protected:
  void SetUp() override {
    source_ = real_recordings() / "livox_mid100";
    if (!std::filesystem::exists(source_)) GTEST_SKIP() << "no real recordings in " << source_.parent_path();
    folder_ = scratch_folder("real_mid100");
    read_published();
    name_sensors();
  }

  /// The published clouds as a patch folder, each under this stop.
  void copy_clouds(const std::filesystem::path& patches, const std::string& stop_middle,
                   const std::string& stop_right) const {
    for (const auto& [file, name] : {std::pair{middle_file_, stop_middle}, {right_file_, stop_right}}) {
      const std::filesystem::path unit = patches / std::filesystem::path(file).parent_path();
      std::filesystem::create_directories(unit);
      std::filesystem::copy_file(source_ / file, unit / (name + ".pcd"));
    }
  }

  /// Writes `rig_` beside the test's folder and gives the path.
  [[nodiscard]] std::string write_rig_file() const {
    const std::string path = (folder_ / "rig.yaml").string();
    std::ofstream(path) << write_rig(rig_);
    return path;
  }

  /// The distance of the two clouds under these poses, see `median_point_to_plane_m`.
  [[nodiscard]] double distance_m(const SE3& T_middle, const SE3& T_right) const {
    return median_point_to_plane_m(cloud(middle_file_, T_middle), cloud(right_file_, T_right), 4);
  }

  static constexpr const char* middle_file_ = "mid100_middle/10.pcd";
  static constexpr const char* right_file_ = "mid100_right/12.pcd";
  std::filesystem::path source_;
  std::filesystem::path folder_;  ///< Empty, for the test.
  Rig rig_;                       ///< avia (the base), mid100_middle, mid100_right.
  std::vector<SE3> all_poses_;    ///< T_G_avia at every stop, the first the identity.
  std::vector<SE3> poses_;        ///< The same at the stop of the middle and of the right unit's cloud.
  std::vector<SE3> extrinsics_;   ///< T_avia_unit of the middle and of the right unit.

 private:
  static std::vector<double> numbers_in(const std::filesystem::path& path, bool joined) {
    std::string s = text_of(path);
    // The extrinsics' lines run together: a number that begins right behind six digits of another one.
    if (joined) {
      for (std::size_t at = 1; at + 1 < s.size(); ++at) {
        if (s[at] == '-' && std::isdigit(static_cast<unsigned char>(s[at - 1])) != 0) s.insert(at++, 1, ' ');
      }
    }
    std::stringstream numbers(s);
    std::vector<double> out;
    for (double x = 0.0; numbers >> x;) out.push_back(x);
    return out;
  }

  static SE3 pose_at(const std::vector<double>& v, std::size_t row) {
    const double* p = v.data() + 7 * row;
    return {rotation_from_xyzw({p[4], p[5], p[6], p[3]}), {p[0], p[1], p[2]}};
  }

  void read_published() {
    const auto poses = numbers_in(source_ / "published" / "pose.json", false);
    const auto extrinsics = numbers_in(source_ / "published" / "ref.json", true);
    ASSERT_GE(poses.size(), 13U * 7U);
    ASSERT_EQ(extrinsics.size(), 3U * 7U);
    for (std::size_t j = 0; 7 * j + 6 < poses.size(); ++j) all_poses_.push_back(pose_at(poses, j));
    poses_ = {all_poses_[10], all_poses_[12]};
    extrinsics_ = {pose_at(extrinsics, 1), pose_at(extrinsics, 2)};
  }

  void name_sensors() {
    rig_.name = "mid100";
    rig_.sensors.resize(3);
    const char* names[] = {"avia", "mid100_middle", "mid100_right"};
    constexpr std::uint8_t last[] = {179, 91, 161};
    for (std::size_t i = 0; i < 3; ++i) {
      rig_.sensors[i].name = names[i];
      rig_.sensors[i].lidar.emplace();
      rig_.sensors[i].lidar->model = i == 0 ? LidarModel::livox_avia : LidarModel::livox_mid40;
      rig_.sensors[i].lidar->ip = {192, 168, 1, last[i]};
      if (i > 0) rig_.sensors[i].initial_T_base_sensor = extrinsics_[i - 1];
    }
  }

  [[nodiscard]] std::vector<Vector3d> cloud(const char* file, const SE3& T) const {
    const auto read = read_pcd((source_ / file).string());
    std::vector<Vector3d> out;
    for (const Point& p : read->points) out.push_back(T * Vector3d(p.x, p.y, p.z));
    return out;
  }
};

}  // namespace rigcal
