#include "core/io/foreign_file.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "core/io/patch_folder.h"
#include "tests/core/io/read_dump.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string error_of(const std::string& name, std::string begin) {
  begin.resize(100, '\0');
  return read_all(write_bytes(name, Bytes(begin.begin(), begin.end()))).error;
}

TEST(ForeignFile, IsNamedWithWhatToDoWhereADumpIsAskedFor) {
  EXPECT_THAT(error_of("bag_0.db3", "SQLite format 3"), AllOf(HasSubstr("bags of ROS 2"), HasSubstr("a ROS 1 bag")));
  EXPECT_THAT(error_of("bag_0.mcap", "\x89MCAP0\r\n"), AllOf(HasSubstr("bags of ROS 2"), HasSubstr("a ROS 1 bag")));
  EXPECT_THAT(error_of("0.pcd", "# .PCD v0.7\n"), AllOf(HasSubstr("a single cloud (PCD)"), HasSubstr("<stop>.pcd")));
  EXPECT_THAT(error_of("1.pcd", "VERSION 0.7\n"), HasSubstr("a single cloud (PCD)"));
  EXPECT_THAT(error_of("a.ply", "ply\nformat ascii 1.0\n"), HasSubstr("a single cloud (PLY)"));
  EXPECT_THAT(error_of("a.las", "LASF"), HasSubstr("a single cloud (LAS)"));
  EXPECT_THAT(error_of("a.txt", "anything else"), HasSubstr("no packet dump"));
}

TEST(ForeignFile, IsNamedWhereItIsAFolder) {
  const std::filesystem::path folder = scratch_folder("ros2_bag");
  std::ofstream(folder / "metadata.yaml") << "rosbag2_bagfile_information:\n";
  EXPECT_EQ(foreign_folder_error(folder.string()), std::nullopt);
  std::ofstream(folder / "bag_0.mcap") << "x";
  Rig rig;
  rig.sensors.emplace_back();
  rig.sensors[0].name = "top";
  rig.sensors[0].lidar.emplace();
  const auto listed = list_patch_folder(folder.string(), rig, {});
  ASSERT_FALSE(listed);
  EXPECT_THAT(listed.error().message(), AllOf(HasSubstr("a bag of ROS 2"), Not(HasSubstr("no folder for any LiDAR"))));
}

}  // namespace
}  // namespace rigcal
