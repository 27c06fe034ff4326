// The real clouds as the device would have sent them: a dump of SDK packets, through inspect, export and calibrate.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "apps/exchange/patch_export.h"
#include "apps/inspection/inspection.h"
#include "apps/recording/recording.h"
#include "core/base/random.h"
#include "core/io/pcapng_writer.h"
#include "drivers/livox_codec/discovery.h"
#include "drivers/livox_codec/sample_packet.h"
#include "tests/apps/real/real_mid100.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t start_ns = 1'700'000'000'000'000'000;
constexpr std::int64_t millisecond_ns = 1'000'000;

// Both clouds show the same motionless scene, so they can stand for one rig at one stop: the middle unit is its base,
// and the right unit's extrinsic is where the right unit stood at stop 12, seen from the middle unit at stop 10.
//
// A MID-40 has no gyro, and the real AVIA's data are not published: an AVIA that sees nothing (all its slots say "no
// return") lends an inertial unit that is at rest all the time. The dump has no time of moving then; the points come
// one second after the first reading, that none falls into the margin of the stop.
class RealMid100Dump : public RealMid100 {
 protected:
  void SetUp() override {
    RealMid100::SetUp();
    if (IsSkipped()) return;
    rig_.base = 1;
    rig_.sensors[0].initial_T_base_sensor.reset();
    rig_.sensors[1].initial_T_base_sensor.reset();
    rig_.sensors[2].initial_T_base_sensor = published();
    // The nearest points are 1.17 m away, which Livox units distort: left out unless the rig file says otherwise.
    for (std::size_t i = 1; i < 3; ++i) rig_.sensors[i].lidar->range_m = {1.0, 100.0};
    rig_file_ = write_rig_file();
    dump_ = (folder_ / "run.pcapng").string();
    for (std::size_t i = 0; i < 2; ++i) {
      auto cloud = read_pcd((source_ / (i == 0 ? middle_file_ : right_file_)).string());
      ASSERT_TRUE(cloud) << cloud.error().message();
      clouds_.push_back(std::move(cloud->points));
    }
    write_dump();
  }

  /// T_middle_right by the published numbers.
  [[nodiscard]] SE3 published() const { return (poses_[0] * extrinsics_[0]).inverse() * (poses_[1] * extrinsics_[1]); }

  static std::size_t packets_of(const std::vector<Point>& cloud) { return (cloud.size() + 99) / 100; }

  // Type 0 packets hold 100 shots, 10 us apart; the last one of a cloud is filled up with slots without return.
  void write_dump() {
    Expected<PcapngWriter> writer = PcapngWriter::create(dump_);
    ASSERT_TRUE(writer);
    Random noise(3);
    constexpr int last_ms = 4500;
    for (int ms = 0; ms < last_ms; ++ms) {
      if (ms % 5 == 0) write_imu(*writer, ms, noise);
      if (ms < 10) write_points(*writer, 0, ms, {}, livox::DataType::cartesian_tagged);
      if (ms < 1000) continue;
      for (std::size_t unit = 0; unit < 2; ++unit) {
        const std::vector<Point>& cloud = clouds_[unit];
        const std::size_t first = 100 * static_cast<std::size_t>(ms - 1000);
        if (first >= cloud.size()) continue;
        const std::span<const Point> part =
            std::span(cloud).subspan(first, std::min<std::size_t>(100, cloud.size() - first));
        write_points(*writer, unit + 1, ms, part, livox::DataType::cartesian);
      }
    }
    ASSERT_TRUE(writer->close());
  }

  void write_points(PcapngWriter& writer, std::size_t sensor, int ms, std::span<const Point> points,
                    livox::DataType type) {
    std::vector<Point> shots(points.begin(), points.end());
    for (std::size_t i = 0; i < shots.size(); ++i) shots[i].shot = static_cast<std::uint16_t>(i);
    livox::SampleHeader header;
    header.lidar_id = static_cast<std::uint8_t>(sensor == 0 ? 1 : sensor + 1);
    header.data_type = type;
    // An AVIA fires a packet in 0.4 ms.
    header.device_stamp_ns = type == livox::DataType::cartesian ? ms * millisecond_ns : ms * 400'000;
    livox::encode_points(header, shots, bytes_);
    send(writer, sensor, livox::kPointSourcePort, ms);
  }

  void write_imu(PcapngWriter& writer, int ms, Random& noise) {
    livox::ImuReading reading;
    for (float& rate : reading.gyro_rad_s) rate = static_cast<float>(1e-3 * noise.normal());
    for (float& g : reading.acceleration_g) g = static_cast<float>(1e-3 * noise.normal());
    reading.acceleration_g[2] += 1.0F;
    livox::SampleHeader header;
    header.data_type = livox::DataType::imu;
    header.device_stamp_ns = ms * millisecond_ns;
    livox::encode_imu(header, reading, bytes_);
    send(writer, 0, livox::kImuSourcePort, ms);
  }

  void send(PcapngWriter& writer, std::size_t sensor, std::uint16_t port, int ms) {
    ASSERT_TRUE(writer.write(
        {start_ns + ms * millisecond_ns, {*rig_.sensors[sensor].lidar->ip, port}, {{192, 168, 1, 5}, 56001}, bytes_}));
  }

  /// Each point and their order, to the bit.
  void expect_cloud(const fs::path& path, std::size_t unit) const {
    const auto back = read_pcd(path.string());
    ASSERT_TRUE(back) << back.error().message();
    ASSERT_EQ(back->points.size(), clouds_[unit].size());
    for (std::size_t i = 0; i < back->points.size(); ++i) {
      const Point& a = back->points[i];
      const Point& b = clouds_[unit][i];
      ASSERT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z && a.reflectivity == b.reflectivity) << path << " " << i;
    }
  }

  Expected<CalibrationResult> calibrate(const std::string& path) {
    const RunContext context{reporter_};
    const auto recording = read_recording({path, rig_file_, {}}, CellOptions{}, context);
    if (!recording) return recording.error();
    points_used_.push_back(recording->points);
    const std::vector<std::optional<SE3>> guess{std::nullopt, SE3{}, published()};
    return calibrate_lidars(recording->rig, recording->lidar, guess, {}, context);
  }

  SilentReporter reporter_;
  std::string rig_file_;
  std::string dump_;
  std::vector<std::vector<Point>> clouds_;  ///< Of the middle and the right unit.
  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint64_t> points_used_;  ///< By each calibration, in its cells.
};

TEST_F(RealMid100Dump, InspectCountsEveryPoint) {
  const auto source = open_stream(dump_, rig_file_);
  ASSERT_TRUE(source) << source.error().message();
  const auto inspection = inspect_recording(*source, {reporter_});
  ASSERT_TRUE(inspection) << inspection.error().message();
  EXPECT_EQ((*inspection)["not_livox"], 0);
  EXPECT_EQ((*inspection)["complete"], true);
  std::map<std::string, Inspection> devices;
  for (const Inspection& device : (*inspection)["devices"]) devices[device["sensor"].get<std::string>()] = device;
  ASSERT_EQ(devices.size(), 3U);
  for (std::size_t unit = 0; unit < 2; ++unit) {
    const Inspection& device = devices[rig_.sensors[unit + 1].name];
    EXPECT_EQ(device["points"], clouds_[unit].size());
    EXPECT_EQ(device["shots"], 100 * packets_of(clouds_[unit]));
    EXPECT_EQ(device["point_packets"]["packets"], packets_of(clouds_[unit]));
    for (const char* none : {"lost", "duplicates", "out_of_order", "restarts", "gaps"}) {
      EXPECT_EQ(device["point_packets"][none], 0) << none;
    }
    EXPECT_EQ(device["noise"], 0);
    EXPECT_EQ(device["out_of_range"], 0);
    EXPECT_EQ(device["malformed"], 0);
  }
  ASSERT_EQ((*inspection)["stops"].size(), 1U);
  EXPECT_EQ((*inspection)["stops"][0]["points"]["mid100_middle"], clouds_[0].size());
  EXPECT_EQ((*inspection)["stops"][0]["points"]["mid100_right"], clouds_[1].size());
  EXPECT_EQ((*inspection)["points"]["in_stops"], clouds_[0].size() + clouds_[1].size());
  for (const auto& [reason, count] : (*inspection)["points"]["dropped"].items()) EXPECT_EQ(count, 0) << reason;
}

TEST_F(RealMid100Dump, ExportGivesEveryPointBackInOrderAndToTheBit) {
  const auto source = open_stream(dump_, rig_file_);
  ASSERT_TRUE(source) << source.error().message();
  ASSERT_TRUE(export_patches(*source, PatchLayout::patches, (folder_ / "patches").string(), {reporter_}));
  expect_cloud(folder_ / "patches" / "mid100_middle" / "0.pcd", 0);
  expect_cloud(folder_ / "patches" / "mid100_right" / "0.pcd", 1);
  ASSERT_TRUE(export_patches(*source, PatchLayout::pcd, (folder_ / "clouds").string(), {reporter_}));
  expect_cloud(folder_ / "clouds" / "mid100_middle_0.pcd", 0);
  expect_cloud(folder_ / "clouds" / "mid100_right_0.pcd", 1);
}

TEST_F(RealMid100Dump, CalibrateFindsTheSameAsFromThePublishedFilesThemselves) {
  const auto from_packets = calibrate(dump_);
  ASSERT_TRUE(from_packets) << from_packets.error().message();
  copy_clouds(folder_ / "patches", "0", "0");
  const auto from_files = calibrate((folder_ / "patches").string());
  ASSERT_TRUE(from_files) << from_files.error().message();
  EXPECT_EQ(points_used_[0], points_used_[1]);
  EXPECT_GT(points_used_[0], 480'000U);
  const SensorResult& right = from_packets->sensors[2];
  ASSERT_TRUE(right.T_base_sensor && from_files->sensors[2].T_base_sensor);
  EXPECT_EQ(right.T_base_sensor->matrix(), from_files->sensors[2].T_base_sensor->matrix());
  EXPECT_EQ(right.covariance, from_files->sensors[2].covariance);
  EXPECT_EQ(right.status, from_files->sensors[2].status);
  // The AVIA that saw nothing is not made up.
  EXPECT_EQ(from_packets->sensors[0].status, Status::failed);
  const double published_mm = 1e3 * distance_m({}, published());
  const double ours_mm = 1e3 * distance_m({}, *right.T_base_sensor);
  std::printf("median point-to-plane distance: %.2f mm, published calibration %.2f mm\n", ours_mm, published_mm);
  EXPECT_GT(published_mm, 10.0);
  EXPECT_LE(ours_mm, 6.5);
}

}  // namespace
}  // namespace rigcal
