#include "apps/recording/datagram_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "apps/exchange/patch_export.h"
#include "apps/exchange/session_import.h"
#include "apps/inspection/inspection.h"
#include "apps/recording/batch_source.h"
#include "apps/recording/recording.h"
#include "core/io/pcapng_writer.h"
#include "core/io/session_folder.h"
#include "drivers/livox_codec/sample_packet.h"
#include "tests/core/io/dump_bytes.h"
#include "tests/support/noting_reporter.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

constexpr std::int64_t s = 1'000'000'000;
constexpr std::int64_t start_ns = 1'700'000'000 * s;
constexpr std::int64_t packet_ns = 400'000;
constexpr int packets = 5000;

class DatagramFileTest : public testing::Test {
 protected:
  /// A dump of an AVIA for two seconds; after half of them the clock of the recording machine is off by `step_ns`.
  [[nodiscard]] std::string dump(std::int64_t step_ns) const {
    std::string path = (folder_ / "dump.pcapng").string();
    Expected<PcapngWriter> writer = PcapngWriter::create(path);
    livox::SampleHeader header;
    header.data_type = livox::DataType::cartesian_tagged;
    std::vector<Point> points(96, Point{5.0F, 1.0F, 1.0F, 80, 0x10, 0});
    for (std::size_t i = 0; i < points.size(); ++i) points[i].shot = static_cast<std::uint16_t>(i);
    std::vector<std::uint8_t> bytes;
    for (int i = 0; i < packets; ++i) {
      header.device_stamp_ns = 5 * s + i * packet_ns;
      livox::encode_points(header, points, bytes);
      const std::int64_t stamp_ns = start_ns + i * packet_ns + (2 * i >= packets ? step_ns : 0);
      EXPECT_TRUE(writer->write({stamp_ns, {{192, 168, 1, 179}, 60001}, {{192, 168, 1, 5}, 56001}, bytes}));
    }
    EXPECT_TRUE(writer->close());
    return path;
  }
  fs::path folder_ = scratch_folder("datagrams");
};

Rig one_avia() {
  Rig rig;
  Sensor sensor;
  sensor.name = "top";
  sensor.lidar.emplace();
  sensor.lidar->model = LidarModel::livox_avia;
  sensor.lidar->ip = {192, 168, 1, 179};
  rig.sensors.push_back(sensor);
  return rig;
}

struct Seen {
  std::vector<std::int64_t> stamps;
  std::vector<std::string> findings;
};

Seen points_of(const std::string& path) {
  Seen seen;
  auto source =
      open_batches(path, one_avia(), {[&](PointBatch& batch) { seen.stamps.push_back(batch.stamp_ns); }, {}, {}});
  EXPECT_TRUE(source) << source.error().message();
  while (*(*source)->read_some()) continue;
  seen.findings = (*source)->notes().findings;
  return seen;
}

TEST_F(DatagramFileTest, GoesOnWhereTheClockOfTheMachineWasSetBack) {
  const Seen seen = points_of(dump(-3600 * s));
  ASSERT_GE(seen.stamps.size(), packets - 5U);
  EXPECT_TRUE(std::is_sorted(seen.stamps.begin(), seen.stamps.end()));
  EXPECT_NEAR(1e-9 * static_cast<double>(seen.stamps.back() - start_ns), 1e-9 * packets * packet_ns, 0.002);
  EXPECT_THAT(seen.findings, ElementsAre("the clock of the recording machine was set back by 3600.0 s at frame 2501; "
                                         "time goes on from there"));
}

TEST_F(DatagramFileTest, TellsNothingWhereItWasSetForwardOrALittleBack) {
  for (const std::int64_t step_ns : {std::int64_t{0}, 3600 * s, -9 * s / 10}) {
    const Seen seen = points_of(dump(step_ns));
    EXPECT_THAT(seen.findings, testing::IsEmpty());
    ASSERT_FALSE(seen.stamps.empty());
    EXPECT_NEAR(1e-9 * static_cast<double>(seen.stamps.back() - start_ns - step_ns), 2.0, 0.1);
  }
}

// The session's packets do not tell it any more.
TEST_F(DatagramFileTest, LeavesWhatItToldToTheSessionThatIsMadeOfIt) {
  const std::string rig = (folder_ / "rig.yaml").string();
  std::ofstream(rig) << "rigcal: 1\nname: one\nbase: top\nsensors:\n  top: {type: livox_avia, ip: 192.168.1.179}\n";
  NotingReporter notes;
  const std::string out = (folder_ / "session").string();
  const auto imported = import_session({dump(-3600 * s), rig, {}}, out, {notes});
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_TRUE(imported->complete);
  EXPECT_THAT(notes.warnings, testing::Contains(testing::HasSubstr("was set back by 3600.0 s")));
  const auto session = open_session(out);
  ASSERT_TRUE(session) << session.error().message();
  EXPECT_TRUE(session->record->end_ns);
  EXPECT_THAT(session->record->gaps,
              ElementsAre(testing::HasSubstr("dump.pcapng: the clock of the recording machine")));
}

// As `tcpdump -s 100` leaves it: no packet is whole, and nothing else says why.
TEST_F(DatagramFileTest, TellsThatPacketsWereCutAheadOfTheErrorThatComesOfIt) {
  const std::string rig = (folder_ / "rig.yaml").string();
  std::ofstream(rig) << "rigcal: 1\nname: one\nbase: top\nsensors:\n  top: {type: livox_avia, ip: 192.168.1.5}\n";
  const Bytes frame = ethernet(ip_udp(Bytes(1400, 7)));
  Bytes dump = pcap_file(1, {});
  for (std::uint64_t i = 0; i < 3; ++i) {
    dump = join({dump, number(1'600'000'000, 4, false), number(i, 4, false), number(100, 4, false),
                 number(frame.size(), 4, false), Bytes(frame.begin(), frame.begin() + 100)});
  }
  const std::string path = (folder_ / "cut.pcap").string();
  save_bytes(path, dump);
  const auto source = open_stream(path, rig);
  ASSERT_TRUE(source) << source.error().message();
  const std::string finding =
      path + ": 3 packets were cut short by the snapshot length of the recording; record with tcpdump -s 0";
  NotingReporter of_dump;
  EXPECT_FALSE(inspect_stream(path, {of_dump}));
  EXPECT_THAT(of_dump.warnings, ElementsAre(finding));
  NotingReporter of_recording;
  EXPECT_FALSE(inspect_recording(*source, {of_recording}));
  EXPECT_THAT(of_recording.warnings, ElementsAre(finding));
  NotingReporter of_export;
  EXPECT_FALSE(export_patches(*source, PatchLayout::pcd, (folder_ / "clouds").string(), {of_export}));
  EXPECT_THAT(of_export.warnings, ElementsAre(finding));
  NotingReporter of_calibration;
  EXPECT_FALSE(read_recording({path, rig, {}}, CellOptions{}, {of_calibration}));
  EXPECT_THAT(of_calibration.warnings, ElementsAre(finding));
}

}  // namespace
}  // namespace rigcal
