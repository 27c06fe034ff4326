// What somebody who never saw rigcal finds in the words of a run that was spoiled in a known way, and without scrolling
// on its page: the verdict, the sensor, the reason. Runs are simulated, spoiled, calibrated by the program, and the
// page is opened in a browser where there is one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/io/pcap_reader.h"
#include "core/io/pcapng_writer.h"
#include "core/rig/rig.h"
#include "drivers/livox_codec/sample_packet.h"
#include "tests/support/court_of_walls.h"
#include "tests/support/files.h"
#include "tests/support/headless_browser.h"
#include "tests/support/json.h"
#include "tests/support/run_program.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;

const std::string camera_rig =
    small_rig(small_camera("eye", "Mono12"),
              "  eye: {translation: [0.05, -0.06, -0.05], rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]}\n");

constexpr std::array<std::uint8_t, 4> mid40_ip{192, 168, 1, 21};

class SpoiledRuns : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch = scratch_folder("spoiled");
    browser = HeadlessBrowser::find(scratch);
  }

  static ProgramRun rigcal(const std::string& arguments) { return run_rigcal(arguments, scratch); }
  static std::string file(const fs::path& name) { return text_of(scratch / name); }

  // What the program says of a calibrated session, and what stands on the first screen of its page, on a desktop and on
  // a phone.
  static void expect_on_first_screen(const std::string& session, const std::string& options, int code,
                                     const testing::Matcher<const std::string&>& content) {
    const std::string result = session + "-result";
    const ProgramRun run = rigcal("calibrate " + session + " --out " + result + " " + options);
    ASSERT_EQ(run.code, code) << run.out << run.err;
    // Faults of the recording do not spoil a good result, and are on the page only.
    const testing::Matcher<const std::string&> good = HasSubstr("good: All ");
    EXPECT_THAT(run.out, code == 0 ? good : content) << session;
    const std::string page = file(fs::path(result) / "report.html");
    EXPECT_LT(page.size(), 20'000'000U);
    if (!browser) {
      std::printf("NOT TESTED, what the page shows: %s\n", HeadlessBrowser::missing);
      return;
    }
    for (const auto& [width, height] : {std::pair{1280, 800}, {390, 844}}) {
      const nlohmann::json seen = browser->seen(page, width, height, false);
      ASSERT_TRUE(seen.value("done", false)) << json_text(seen);
      EXPECT_EQ(seen["screen"], nlohmann::json({width, height}));
      EXPECT_LE(seen["wide_px"].get<int>(), 0);
      // What has one colour only gives 0; a slice along a shared surface may show no more than some dozens of points.
      for (const nlohmann::json& picture : seen["pictures"]) EXPECT_GT(picture.get<double>(), 0.001);
      EXPECT_THAT(seen.value("first_screen", ""), content) << session << " on " << json_text(seen["screen"]);
    }
  }

  // Patches with one camera.
  static void make_camera_session(const std::string& name) {
    if (!fs::exists(scratch / "camera")) {
      std::ofstream(scratch / "camera.yaml") << camera_rig;
      const ProgramRun made = rigcal(
          "simulate courtyard --rig camera.yaml --out camera --patches --stops 8 --points 60000 --mount-error "
          "20mm,1deg");
      ASSERT_EQ(made.code, 0) << made.err;
    }
    fs::create_directories(scratch / name);
    fs::create_directory_symlink(scratch / "camera/patches", scratch / name / "patches");
    fs::copy_file(scratch / "camera/session.json", scratch / name / "session.json");
    fs::copy_file(scratch / "camera/rig.yaml", scratch / name / "rig.yaml");
  }
  static void replace_in_rig(const std::string& session, const std::string& from, const std::string& to) {
    std::string rig = file(fs::path(session) / "rig.yaml");
    const std::size_t at = rig.find(from);
    ASSERT_NE(at, std::string::npos) << from << rig;
    std::ofstream(scratch / session / "rig.yaml") << rig.replace(at, from.size(), to);
  }

  // A datagram that is held in memory.
  struct Packet {
    std::int64_t stamp_ns = 0;
    Endpoint from;
    Endpoint to;
    std::vector<std::uint8_t> bytes;
  };
  // What a spoiler makes of one, `seconds` into the recording: false loses it.
  using Spoiler = std::function<bool(double seconds, Packet& packet)>;

  static void make_packet_session(const std::string& name, const Spoiler& spoil) {
    if (!fs::exists(scratch / "packets")) simulate_courtyard(small_rig(), hurried_run(8, 0.9), scratch / "packets");
    fs::create_directories(scratch / name);
    for (const char* same : {"rig.yaml", "session.json"})
      fs::copy_file(scratch / "packets" / same, scratch / name / same);
    auto reader = PcapReader::open(scratch / "packets/lidar.pcapng");
    auto writer = PcapngWriter::create(scratch / name / "lidar.pcapng");
    ASSERT_TRUE(reader && writer);
    const auto write = [&](const Packet& packet) {
      ASSERT_TRUE(writer->write({packet.stamp_ns, packet.from, packet.to, packet.bytes}));
    };
    std::deque<Packet> late;  // files are in the order of their stamps
    Datagram datagram;
    std::int64_t first_ns = 0;
    for (Expected<bool> more = reader->next(datagram); more && *more; more = reader->next(datagram)) {
      if (first_ns == 0) first_ns = datagram.stamp_ns;
      Packet packet{datagram.stamp_ns, datagram.from, datagram.to, {datagram.bytes.begin(), datagram.bytes.end()}};
      for (; !late.empty() && late.front().stamp_ns <= datagram.stamp_ns; late.pop_front()) write(late.front());
      if (!spoil(1e-9 * static_cast<double>(datagram.stamp_ns - first_ns), packet)) continue;
      if (packet.stamp_ns > datagram.stamp_ns) {
        late.push_back(std::move(packet));
      } else {
        write(packet);
      }
    }
    ASSERT_TRUE(writer->close());
  }

  inline static fs::path scratch;
  inline static std::optional<HeadlessBrowser> browser;
};

TEST_F(SpoiledRuns, GoodIsSaidOfAGoodRun) {
  make_camera_session("good");
  expect_on_first_screen("good", "--require 30mm,0.3deg", 0, HasSubstr("✓ good All 3 sensors are good."));
}

TEST_F(SpoiledRuns, OfAWrongFocalLengthTheCameraIsNamed) {
  make_camera_session("focal");
  for (const char* which : {"fx: 431.5", "fy: 431.5"}) {
    replace_in_rig("focal", which, std::string(which).substr(0, 4) + "449.0");
  }
  expect_on_first_screen(
      "focal", "--require 30mm,0.3deg", 1,
      AllOf(HasSubstr("2 of 3 sensors are good: eye is weak."), HasSubstr("the images fit better with a focal length "),
            HasSubstr(" % shorter than the rig file's; calibrate its intrinsics anew, or try --refine-intrinsics")));
}

TEST_F(SpoiledRuns, OfALidarThatSeesOnlyWallsTheOpenDirectionIsNamed) {
  std::ofstream(scratch / "court_rig.yaml") << court_rig;
  std::ofstream(scratch / "court.yaml") << court_scene;
  const ProgramRun made = rigcal(
      "simulate court.yaml --rig court_rig.yaml --out court --patches --stops 12 --points 40000 --seed 3 "
      "--mount-error 20mm,1deg");
  ASSERT_EQ(made.code, 0) << made.err;
  expect_on_first_screen("court", "", 1,
                         AllOf(HasSubstr("2 of 3 sensors are good: straight is weak."),
                               HasSubstr("worst along z (up and down) of the base frame; add stops that see a surface "
                                         "facing that way")));
}

// `straight` looks backwards here, where the base sees nothing.
TEST_F(SpoiledRuns, OfOneStopTheLidarThatItDoesNotConnectIsNamed) {
  std::string rig = court_rig;
  rig.replace(rig.find("0.0, 0.0, 0.258819, 0.965926"), 28, "0.0, 0.0, -0.965926, 0.258819");
  std::ofstream(scratch / "one.yaml") << rig;
  const ProgramRun made =
      rigcal("simulate courtyard --rig one.yaml --out one --patches --stops 1 --points 60000 --mount-error 20mm,1deg");
  ASSERT_EQ(made.code, 0) << made.err;
  expect_on_first_screen("one", "", 1,
                         AllOf(HasSubstr("straight failed"),
                               HasSubstr("no pose near its initial extrinsics lays its surfaces on those of avia"),
                               HasSubstr("or add stops in which both see the same surfaces")));
}

TEST_F(SpoiledRuns, OfALossyRecordingTheLossesAreToldAlthoughTheResultIsGood) {
  Random random(5);
  make_packet_session("lossy", [&](double seconds, Packet& packet) {
    const bool silent = packet.from.ip == mid40_ip && seconds > 4.0 && seconds < 7.0;
    return !silent && random.uniform() >= 0.03;
  });
  expect_on_first_screen("lossy", "", 0,
                         AllOf(HasSubstr("✓ good All 2 sensors are good."),
                               HasSubstr("But the recording has faults: packets lost (avia, mid40)."),
                               testing::ContainsRegex("2[0-9] % of its point packets are lost \\([0-9]+ in [0-9]+ "
                                                      "gaps, the longest 3.0 s\\); check cable and switch")));
}

TEST_F(SpoiledRuns, OfAClockThatJumpsTheSensorIsNamed) {
  constexpr std::size_t stamp_byte = 15;  // of the little-endian stamp: steps of 18 minutes
  make_packet_session("jumps", [&](double seconds, Packet& packet) {
    if (packet.from.ip == mid40_ip && seconds > 5.0 && livox::parse_sample_packet(packet.bytes)) {
      packet.bytes[stamp_byte] =
          static_cast<std::uint8_t>(packet.bytes[stamp_byte] + 1 + static_cast<int>((seconds - 5.0) / 2.0));
    }
    return true;
  });
  expect_on_first_screen(
      "jumps", "", 0,
      AllOf(HasSubstr("✓ good All 2 sensors are good."), HasSubstr("But the recording has faults: clock (mid40)."),
            HasSubstr("its clock jumped "), HasSubstr("check its power and what sets its clock")));
}

TEST_F(SpoiledRuns, OfPacketsThatAnotherClockStampedTheSensorIsNamed) {
  make_packet_session("late", [](double, Packet& packet) {
    if (packet.from.ip == mid40_ip) packet.stamp_ns += 1'000'000'000;
    return true;
  });
  expect_on_first_screen("late", "", 1,
                         AllOf(AnyOf(HasSubstr("mid40 failed."), HasSubstr("mid40 is weak.")),
                               HasSubstr("its packets are stamped by another clock than the others'")));
}

}  // namespace
}  // namespace rigcal
