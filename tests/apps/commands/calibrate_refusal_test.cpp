// What `rigcal calibrate` refuses: one line that names the file and the mend, exit code 3, and no result folder.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/io/pcapng_writer.h"
#include "drivers/livox_codec/discovery.h"
#include "drivers/livox_codec/sample_packet.h"
#include "tests/support/run_program.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* rig_yaml = R"(rigcal: 1
base: avia
sensors:
  avia: {type: livox_avia, ip: 192.168.1.179}
  mid40: {type: livox_mid40, ip: 192.168.1.21}
)";
constexpr std::array<std::uint8_t, 4> avia_ip{192, 168, 1, 179};
constexpr std::array<std::uint8_t, 4> mid40_ip{192, 168, 1, 21};
constexpr std::array<std::uint8_t, 4> host_ip{192, 168, 1, 5};
constexpr std::int64_t start_ns = 1'700'000'000'000'000'000;
constexpr std::int64_t second_ns = 1'000'000'000;

class CalibrateRefusal : public testing::Test {
 protected:
  void SetUp() override {
    scratch = scratch_folder("refusal");
    write("rig.yaml", rig_yaml);
  }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(scratch / name, std::ios::binary) << text;
  }

  // Each part of the message is asked for; the result must not be there.
  void expect_refused(const std::string& arguments, const std::string& where, const std::string& what,
                      const std::string& mend) const {
    const ProgramRun run = run_rigcal("calibrate --out result " + arguments, scratch);
    EXPECT_EQ(run.code, 3) << arguments;
    EXPECT_EQ(run.out, "");
    EXPECT_THAT(run.err, AllOf(StartsWith("rigcal: error: " + where), HasSubstr(what), HasSubstr("; " + mend)));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(fs::exists(scratch / "result"));
  }

  // Five seconds of the rig; `rate_rad_s` is what the gyro reads.
  void write_run(const std::string& name, bool with_mid40, const std::function<double(double)>& rate_rad_s) const {
    auto writer = PcapngWriter::create((scratch / name).string());
    ASSERT_TRUE(writer) << writer.error().message();
    const std::vector<Point> points{{10.0F, 1.0F, 0.5F, 50, 0, 3}};
    std::vector<std::uint8_t> bytes;
    Random random(1);
    for (std::int64_t t = 0; t < 5 * second_ns; t += second_ns / 200) {
      livox::SampleHeader header;
      header.device_stamp_ns = t;
      const auto send = [&](const std::array<std::uint8_t, 4>& from, std::uint16_t port) {
        EXPECT_TRUE(writer->write({start_ns + t, {from, port}, {host_ip, 56001}, bytes}));
      };
      header.data_type = livox::DataType::imu;
      const double z = rate_rad_s(static_cast<double>(t) * 1e-9) + 1e-3 * random.normal();
      livox::encode_imu(header, {{0.0F, 0.0F, static_cast<float>(z)}, {0.0F, 0.0F, 1.0F}}, bytes);
      send(avia_ip, livox::kImuSourcePort);
      header.data_type = livox::DataType::cartesian_tagged;
      livox::encode_points(header, points, bytes);
      send(avia_ip, livox::kPointSourcePort);
      if (!with_mid40) continue;
      header.data_type = livox::DataType::cartesian;
      livox::encode_points(header, points, bytes);
      send(mid40_ip, livox::kPointSourcePort);
    }
    ASSERT_TRUE(writer->close());
  }

  fs::path scratch;
};

TEST_F(CalibrateRefusal, OfWhatIsNotThere) {
  expect_refused("nowhere.pcap --rig rig.yaml", "nowhere.pcap: ", "no such file", "check the path");
  write("run.pcap", "");
  expect_refused("run.pcap --rig nowhere.yaml", "nowhere.yaml: ", "", "");
  expect_refused("run.pcap", "run.pcap: ", "needs the rig", "add --rig");
}

TEST_F(CalibrateRefusal, OfWhatIsNoDump) {
  write("empty.pcap", "");
  expect_refused("empty.pcap --rig rig.yaml", "empty.pcap: ", "empty", "");
  Random random(7);
  std::string noise;
  for (int i = 0; i < 100'000; ++i) noise += static_cast<char>(random.below(256));
  write("noise.pcap", noise);
  expect_refused("noise.pcap --rig rig.yaml", "noise.pcap: ", "", "");
}

TEST_F(CalibrateRefusal, OfADumpWithoutALivoxPacket) {
  auto writer = PcapngWriter::create((scratch / "other.pcapng").string());
  ASSERT_TRUE(writer) << writer.error().message();
  Random random(3);
  for (int k = 0; k < 500; ++k) {
    std::vector<std::uint8_t> bytes(1 + random.below(1400));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.below(256));
    ASSERT_TRUE(writer->write({start_ns + k * 1'000'000, {avia_ip, 2368}, {host_ip, 2368}, bytes}));
  }
  ASSERT_TRUE(writer->close());
  expect_refused("other.pcapng --rig rig.yaml", "other.pcapng: ", "no Livox packet among 500 UDP datagrams", "record");
}

TEST_F(CalibrateRefusal, OfRigFilesWithMistakes) {
  write_run("run.pcapng", true, [](double) { return 0.0; });
  write("unknown.yaml", std::string(rig_yaml) + "turntabel: {driver: manual}\n");
  expect_refused("run.pcapng --rig unknown.yaml", "unknown.yaml:6: ", "turntabel", "");
  expect_refused("run.pcapng --rig unknown.yaml", "unknown.yaml:6: ", "turntable", "");
  std::string text = rig_yaml;
  write("no_base.yaml", text.replace(text.find("base: avia\n"), 11, ""));
  expect_refused("run.pcapng --rig no_base.yaml", "no_base.yaml", "base", "");
  text = rig_yaml;
  write("other_base.yaml", text.replace(text.find("base: avia"), 10, "base: aiva"));
  expect_refused("run.pcapng --rig other_base.yaml", "other_base.yaml:2: ", "aiva", "");
  text = rig_yaml;
  write("type.yaml", text.replace(text.find("livox_mid40"), 11, "[1, 2]"));
  expect_refused("run.pcapng --rig type.yaml", "type.yaml:5: ", "type", "");
  text = rig_yaml;
  write("ip.yaml", text.replace(text.find("192.168.1.21"), 12, "192.168.1.256"));
  expect_refused("run.pcapng --rig ip.yaml", "ip.yaml:5: ", "sensors.mid40.ip", "write it like");
}

TEST_F(CalibrateRefusal, OfADumpWithoutALidarOfTheRig) {
  write_run("run.pcapng", false, [](double) { return 0.0; });
  expect_refused("run.pcapng --rig rig.yaml", "run.pcapng: ", "mid40 (192.168.1.21)", "correct ip");
}

TEST_F(CalibrateRefusal, OfARigThatNeverStandsStill) {
  write_run("run.pcapng", true, [](double t) { return 0.6 * std::sin(2.0 * pi * t); });
  expect_refused("run.pcapng --rig rig.yaml", "run.pcapng: ", "never stands still", "let the rig rest");
}

// Not that it never stands still.
TEST_F(CalibrateRefusal, OfADumpThatIsCutBeforeItsFirstStop) {
  write_run("run.pcapng", true, [](double) { return 0.0; });
  fs::resize_file(scratch / "run.pcapng", 20001);
  expect_refused("run.pcapng --rig rig.yaml", "run.pcapng: ", "no stop is in what can be read of it: ", "record anew");
}

TEST_F(CalibrateRefusal, OfARigWithoutALidar) {
  write_run("run.pcapng", true, [](double) { return 0.0; });
  write("cameras.yaml", "rigcal: 1\nbase: a\nsensors:\n  a: {type: camera}\n");
  expect_refused("run.pcapng --rig cameras.yaml", "cameras.yaml: ", "--method targetless needs one as base", "add it");
  write("board.yaml",
        "rigcal: 1\nbase: a\nsensors:\n  a: {type: camera}\n"
        "board: {type: checkerboard, inner_corners: [7, 5], square: 0.1, size: [0.9, 0.7]}\n");
  expect_refused("run.pcapng --rig board.yaml --method checkerboard",
                 "board.yaml: ", "has no LiDAR, by which the stops", "add it, or give the images by their stops");
}

TEST_F(CalibrateRefusal, OfAPlaceWhereNoResultCanBe) {
  write("file", "");
  const ProgramRun run = run_rigcal("calibrate nowhere --out file/result", scratch);
  EXPECT_EQ(run.code, 4) << "before the input is looked at";
  EXPECT_THAT(run.err, HasSubstr("/file is a file and no folder; choose another place"));
}

TEST_F(CalibrateRefusal, OfPatchesWithoutARig) {
  fs::create_directories(scratch / "patches/avia");
  expect_refused("patches", "patches: ", "needs a rig file", "add --rig");
  expect_refused("patches --rig rig.yaml", "patches", "", "");
}

TEST_F(CalibrateRefusal, OfAResult) {
  fs::create_directories(scratch / "older");
  std::ofstream(scratch / "older/extrinsics.yaml") << "rigcal: 1\n";
  expect_refused("older", "older: ", "is a result, and holds no recording", "give the recording");
}

TEST_F(CalibrateRefusal, OfASessionThatLostItsRig) {
  fs::create_directories(scratch / "session/patches/avia");
  write("session/session.json", "{\"format\": 1, \"start_ns\": 0}");
  for (const char* more : {"", " --rig rig.yaml"})
    expect_refused(std::string("session") + more, "session: ", "has no rig.yaml", "put it back");
}

TEST_F(CalibrateRefusal, OfAnEmptyNameForTheResult) {
  for (const char* command : {"calibrate x", "batch x", "export x --format patches", "import x", "capture --rig x",
                              "simulate room --rig x", "experiment bound"}) {
    const ProgramRun run = run_rigcal(std::string(command) + " --out ''", scratch);
    EXPECT_EQ(run.code, 2) << command;
    EXPECT_THAT(run.err, HasSubstr("--out: is empty"));
  }
}

TEST_F(CalibrateRefusal, OfWhatCamerasWouldNeedWhereTheirStageIsLeftOut) {
  for (const std::string option : {"--images .", "--refine-intrinsics"}) {
    const ProgramRun run = run_rigcal("calibrate . --stages joint --out result " + option, scratch);
    EXPECT_EQ(run.code, 2) << option;
    EXPECT_THAT(run.err, HasSubstr("is of no use with --stages joint")) << option;
  }
}

TEST_F(CalibrateRefusal, OfARecordingThatIsNotThere) {
  expect_refused("nowhere.pcapng --rig rig.yaml", "nowhere.pcapng: ", "no such file", "check the path");
  const ProgramRun run = run_rigcal("export nowhere --format patches --out patches", scratch);
  EXPECT_EQ(run.code, 3);
  EXPECT_THAT(run.err, HasSubstr("nowhere: no such file or folder"));
}

TEST_F(CalibrateRefusal, OfRoughExtrinsicsOfAnotherBase) {
  write_run("run.pcapng", true, [](double) { return 0.0; });
  write("guess.yaml",
        "rigcal: 1\nbase: mid40\nsensors:\n  mid40: {translation: [0, 0, 0], rotation_xyzw: [0, 0, 0, 1]}\n");
  // Errors only: the thin recording loses packets, which is told before.
  expect_refused("run.pcapng --rig rig.yaml --initial guess.yaml --log-level error",
                 "guess.yaml: ", "its base is mid40, and it does not say where avia", "give");
  expect_refused("run.pcapng --rig rig.yaml --initial nowhere.yaml", "nowhere.yaml: ", "", "");
}

}  // namespace
}  // namespace rigcal
