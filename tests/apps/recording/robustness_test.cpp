// Every reader of files against thousands of damaged files: it refuses or reads what is whole, quickly and in little
// memory. That it does not crash is tested by the test being there at its end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "apps/recording/batch_source.h"
#include "apps/recording/datagram_file.h"
#include "core/base/seconds.h"
#include "core/io/extrinsics_file.h"
#include "core/io/frame_files.h"
#include "core/io/image_file.h"
#include "core/io/pcap_reader.h"
#include "core/io/pcapng_writer.h"
#include "core/io/pcd_file.h"
#include "core/io/session_folder.h"
#include "core/io/tum_file.h"
#include "drivers/livox_codec/sample_packet.h"
#include "tests/fuzz/scratch_file.h"
#include "tests/support/broken_reads.h"
#include "tests/support/make_lvx.h"
#include "tests/support/mutations.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

constexpr int mutations = 2000;
constexpr std::int64_t start_ns = 1'700'000'000'000'000'000;

double peak_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

Bytes bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

class Robustness : public testing::Test {
 protected:
  /// A point packet of an AVIA, the n-th.
  static Bytes packet(int n) {
    livox::SampleHeader header;
    header.data_type = livox::DataType::cartesian_tagged;
    header.device_stamp_ns = 1'000'000'000 + std::int64_t{n} * 400'000;
    std::vector<Point> points(96);
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i] = {5.0F, 0.01F * static_cast<float>(i), 1.0F, 80, 0x10, static_cast<std::uint16_t>(i)};
    }
    Bytes bytes;
    livox::encode_points(header, points, bytes);
    return bytes;
  }
  [[nodiscard]] Bytes dump(const std::vector<Bytes>& packets) const {
    const std::string path = (scratch / "dump.pcapng").string();
    Expected<PcapngWriter> writer = PcapngWriter::create(path);
    std::int64_t stamp_ns = start_ns;
    for (const Bytes& each : packets) {
      EXPECT_TRUE(writer->write({stamp_ns += 400'000, {{192, 168, 1, 179}, 60001}, {{192, 168, 1, 5}, 56001}, each}));
    }
    EXPECT_TRUE(writer->close());
    return read_bytes(path);
  }
  static std::vector<Bytes> packets(int count) {
    std::vector<Bytes> all;
    for (int i = 0; i < count; ++i) all.push_back(packet(i));
    return all;
  }
  /// What the program would see of a recording.
  struct Seen {
    IngestSummary summary;
    std::string truncation;
    std::string error;
  };
  static Seen look_at(const Bytes& file) {
    const ScratchFile scratch_file(file.data(), file.size());
    Seen seen;
    const Rig no_rig;
    Expected<std::unique_ptr<BatchSource>> source = open_batches(scratch_file.path(), no_rig, {});
    if (!source) {
      seen.error = source.error().message();
      return seen;
    }
    while (true) {
      const Expected<bool> more = (*source)->read_some();
      if (!more) seen.error = more.error().message();
      if (!more || !*more) break;
    }
    seen.summary = (*source)->summary();
    seen.truncation = (*source)->truncation();
    return seen;
  }
  /// Thousands of damaged files for one reader; what it says of them must be a sentence with a place.
  static void torment(const Bytes& original, const std::function<std::optional<Error>(const std::string&)>& read) {
    const double before_mib = peak_mib();
    const SteadyClock::time_point start = SteadyClock::now();
    Random random(2024);
    int refused = 0;
    for (int i = 0; i < mutations; ++i) {
      const Bytes bytes = mutated(original, random);
      const ScratchFile file(bytes.data(), bytes.size());
      const std::optional<Error> error = read(file.path());
      if (!error) continue;
      ++refused;
      EXPECT_EQ(error->kind, ErrorKind::input) << error->message();
      EXPECT_FALSE(error->what.empty() || error->where.empty()) << error->message();
    }
    EXPECT_GT(refused, 0);
    EXPECT_LT(seconds_since(start), 60.0);
    EXPECT_LT(peak_mib() - before_mib, 100.0);
  }
  template <class T>
  static std::optional<Error> error_of(const Expected<T>& outcome) {
    return outcome ? std::nullopt : std::optional<Error>(outcome.error());
  }
  static std::optional<Error> read_recording_file(const std::string& path) {
    const Rig no_rig;
    Expected<std::unique_ptr<BatchSource>> source = open_batches(path, no_rig, {});
    if (!source) return source.error();
    while (true) {
      const Expected<bool> more = (*source)->read_some();
      if (!more) return more.error();
      if (!*more) return std::nullopt;
    }
  }

  fs::path scratch = scratch_folder("robustness");
};

TEST_F(Robustness, ADumpCutAtAnyByteGivesItsWholePackets) {
  const Bytes whole = dump(packets(4));
  const std::size_t block = 28 + 20 + 8 + packet(0).size() + 4;
  const std::size_t padded = (block + 3) / 4 * 4;
  ASSERT_GT(whole.size(), 2000U);
  for (std::size_t missing = 1; missing <= 2000; ++missing) {
    const Seen seen = look_at(Bytes(whole.begin(), whole.end() - static_cast<std::ptrdiff_t>(missing)));
    ASSERT_EQ(seen.error, "");
    ASSERT_EQ(seen.summary.datagrams, 4 - (missing + padded - 1) / padded) << missing;
    ASSERT_EQ(seen.truncation.empty(), missing % padded == 0) << missing;
  }
}

TEST_F(Robustness, AFlippedBitInEveryPacketIsCountedAndGoneOnFrom) {
  constexpr int count = 10'000;
  Random random(5);
  std::vector<Bytes> all = packets(count);
  for (Bytes& each : all) {
    const auto bit = static_cast<std::size_t>(random.uniform() * 8.0 * static_cast<double>(each.size()));
    each[bit / 8] = static_cast<std::uint8_t>(each[bit / 8] ^ (1U << (bit % 8)));
  }
  // The header of the last packets, bit by bit: every one of its bits is flipped once.
  for (std::size_t bit = 0; bit < 18 * 8; ++bit) {
    all[all.size() - 1 - bit] = packet(count - 1 - static_cast<int>(bit));
    Bytes& each = all[all.size() - 1 - bit];
    each[bit / 8] = static_cast<std::uint8_t>(each[bit / 8] ^ (1U << (bit % 8)));
  }
  const Seen seen = look_at(dump(all));
  EXPECT_EQ(seen.error, "");
  EXPECT_EQ(seen.truncation, "");
  EXPECT_EQ(seen.summary.datagrams, static_cast<std::uint64_t>(count));
  ASSERT_EQ(seen.summary.devices.size(), 1U);
  const DeviceIngest& device = seen.summary.devices[0];
  EXPECT_EQ(device.packets + device.malformed + seen.summary.not_livox, static_cast<std::uint64_t>(count));
  EXPECT_GT(device.malformed, 0U);
  EXPECT_GT(device.packets, static_cast<std::uint64_t>(0.95 * count));
}

TEST_F(Robustness, DamagedPcapng) { torment(dump(packets(5)), read_recording_file); }

TEST_F(Robustness, DamagedPcap) {
  Bytes file;
  ByteWriter out(file);
  for (const std::uint32_t word : {0xA1B23C4DU, 0x00040002U, 0U, 0U, 262'144U, 101U}) out.write(word);
  const Bytes blocks = dump(packets(5));
  const std::size_t packet_bytes = 28 + packet(0).size();
  for (std::size_t i = 0; i < 5; ++i) {  // the packets of the pcapng file behind their 28 bytes of block header
    const std::size_t padded = (packet_bytes + 3) / 4 * 4 + 32;
    const std::size_t at = blocks.size() - (5 - i) * padded + 28;
    for (const std::size_t word : {std::size_t{1'700'000'000}, i, packet_bytes, packet_bytes}) {
      out.write(static_cast<std::uint32_t>(word));
    }
    out.write_bytes(ByteView(blocks).subspan(at, packet_bytes));
  }
  ASSERT_EQ(look_at(file).summary.devices.at(0).packets, 5U);
  torment(file, read_recording_file);
}

TEST_F(Robustness, DamagedLvx) {
  for (const int minor : {0, 1}) {
    LvxDevice device;
    device.broadcast_code = "3JEDHC900100791";
    device.type = 7;
    LvxBuilder lvx(minor, {device});
    for (int frame = 0; frame < 3; ++frame) {
      for (int i = 0; i < 2; ++i) {
        livox::SampleHeader header;
        header.device_stamp_ns = 1'000'000 * (2 * frame + i + 1);
        Bytes bytes;
        std::vector<Point> points(100, Point{3.0F, 1.0F, 0.5F, 9, 0, 0});
        for (std::size_t shot = 0; shot < points.size(); ++shot) points[shot].shot = static_cast<std::uint16_t>(shot);
        livox::encode_points(header, points, bytes);
        lvx.add_package(0, bytes);
      }
      lvx.end_frame();
    }
    ASSERT_EQ(look_at(lvx.bytes()).summary.devices.at(0).packets, 6U) << look_at(lvx.bytes()).error;
    torment(lvx.bytes(), read_recording_file);
  }
}

// What was read is not all that the file holds: a disk that breaks is not the end of a recording.
TEST_F(Robustness, AnLvxFileOnADiskThatBreaks) {
  LvxDevice device;
  device.broadcast_code = "3JEDHC900100791";
  LvxBuilder lvx(1, {device});
  for (int i = 0; i < 3000; ++i) {
    lvx.add_package(0, packet(i));
    lvx.end_frame();
  }
  const fs::path path = scratch / "broken.lvx";
  lvx.save(path.string());
  const auto file = open_datagrams(path.string());
  ASSERT_TRUE(file) << file.error().message();
  Datagram datagram;
  ASSERT_TRUE(*(*file)->next(datagram));
  ASSERT_TRUE(break_reads(path));
  Expected<bool> more = (*file)->next(datagram);
  while (more && *more) more = (*file)->next(datagram);
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error().kind, ErrorKind::system);
  EXPECT_THAT(more.error().message(), HasSubstr("broken.lvx: cannot be read to its end"));
}

TEST_F(Robustness, DamagedPcd) {
  const auto read = [](const std::string& path) { return error_of(read_pcd(path)); };
  const std::string header = "VERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n";
  torment(bytes_of(header + "WIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n"
                            "1 2 3 10\n4.5 -1e3 0.25 200\n7 8 9 255\n"),
          read);
  const std::string path = (scratch / "cloud.pcd").string();
  ASSERT_TRUE(write_pcd(path, std::vector<Point>(40, Point{1.0F, 2.0F, 3.0F, 4, 0, 0})));
  torment(read_bytes(path), read);
  // 40 points of 16 bytes as one literal run after another (LZF): what they say does not matter here.
  Bytes packed = bytes_of(header + "WIDTH 4\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA binary_compressed\n");
  ByteWriter out(packed);
  out.write(std::uint32_t{66});
  out.write(std::uint32_t{64});
  for (int run = 0; run < 2; ++run) {
    out.write(std::uint8_t{31});
    for (int i = 0; i < 8; ++i) out.write(1.5F);
  }
  const ScratchFile good(packed.data(), packed.size());
  ASSERT_EQ(read_pcd(good.path())->points.size(), 4U);
  torment(packed, read);
}

TEST_F(Robustness, DamagedTexts) {
  torment(read_bytes(std::string(RIGCAL_SOURCE_DIR) + "/config/rigs/turntable.yaml"),
          [](const std::string& path) { return error_of(load_rig(path)); });
  torment(bytes_of("rigcal: 1\nbase: a\nmethod: targetless\nstatus: good\nsensors:\n  a:\n    status: good\n"
                   "    reasons: []\n    translation: [0.5, -1.25, 3]\n    rotation_xyzw: [0, 0, 0.6, 0.8]\n"),
          [](const std::string& path) { return error_of(load_extrinsics(path)); });
  torment(bytes_of("# a trajectory\n1700000000.123456789 1 2 3 0 0 0 1\n1700000001.5 -1e-3 0.5 3 0 0 0.6 0.8\n"),
          [](const std::string& path) { return error_of(read_tum(path)); });
  torment(
      bytes_of("file,stamp_ns,trigger,exposure_us,device_stamp,stop\n0.png,1700000000,0,5000.0,77,0\n1.png,18,,,,\n"),
      [](const std::string& path) { return error_of(read_frames(path)); });
  torment(bytes_of("pulse,stamp_ns\n0,1700000000\n1,1700000007\n"),
          [](const std::string& path) { return error_of(read_trigger(path)); });
}

TEST_F(Robustness, DamagedImages) {
  for (const char* name : {"colours.jpg", "grey16.png", "opaque.png"})
    torment(read_bytes(std::string(RIGCAL_SOURCE_DIR) + "/tests/fuzz/corpus/image/" + name),
            [](const std::string& path) { return error_of(read_image(path)); });
}

TEST_F(Robustness, DamagedSessionJson) {
  const fs::path session = scratch / "session";
  fs::create_directories(session);
  fs::copy_file(std::string(RIGCAL_SOURCE_DIR) + "/config/rigs/turntable.yaml", session / "rig.yaml");
  const Bytes packets_file = dump(packets(1));
  fs::rename(scratch / "dump.pcapng", session / "lidar.pcapng");
  SessionRecord record;
  record.start_ns = start_ns;
  record.end_ns = start_ns + 1'000'000'000;
  ASSERT_TRUE(write_session_record(session.string(), record));
  ASSERT_TRUE(open_session(session.string()));
  Random random(11);
  const Bytes original = read_bytes(session / "session.json");
  int refused = 0;
  for (int i = 0; i < mutations; ++i) {
    const Bytes bytes = mutated(original, random);
    save_bytes(session / "session.json", bytes);
    const auto opened = open_session(session.string());
    if (opened) continue;
    ++refused;
    EXPECT_THAT(opened.error().message(), HasSubstr("session.json"));
  }
  EXPECT_GT(refused, mutations / 10);
  std::ofstream(session / "session.json") << std::string(100'000, '[');
  EXPECT_FALSE(open_session(session.string()));
}

TEST_F(Robustness, YamlBombsAreRefusedAtOnce) {
  const SteadyClock::time_point start = SteadyClock::now();
  std::string billion = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    billion += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [";
    for (int k = 0; k < 9; ++k) billion += (k > 0 ? ", " : "") + before;
    billion += "]\n";
  }
  std::string block;
  for (int i = 0; i < 2000; ++i) block += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  const std::vector<std::string> bombs{billion, std::string(200'000, '['),         std::string(200'000, '{'),
                                       block,   "a: " + std::string(100'000, '-'), std::string(100'000, '?') + " a"};
  for (const std::string& bomb : bombs) {
    EXPECT_FALSE(parse_rig(bomb, "bomb.yaml"));
    EXPECT_FALSE(parse_extrinsics(bomb, "bomb.yaml"));
  }
  EXPECT_LT(seconds_since(start), 20.0);
  EXPECT_LT(peak_mib(), 500.0);
}

TEST_F(Robustness, PcdWithoutNumbersOrWithFewerPointsThanItSays) {
  const auto cloud = [](const std::string& counts, const std::string& data) {
    const Bytes bytes =
        bytes_of("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n" + counts + "DATA ascii\n" + data);
    const ScratchFile file(bytes.data(), bytes.size());
    return read_pcd(file.path());
  };
  const auto with_nan = cloud("WIDTH 3\nHEIGHT 1\nPOINTS 3\n", "1 2 3\nnan nan nan\n4 inf 6\n");
  ASSERT_TRUE(with_nan) << with_nan.error().message();
  EXPECT_EQ(with_nan->summary.points, 1U);
  EXPECT_EQ(with_nan->summary.not_finite, 2U);
  const auto none = cloud("WIDTH 0\nHEIGHT 1\nPOINTS 0\n", "");
  EXPECT_TRUE(!none || none->points.empty());
  const auto fewer = cloud("WIDTH 5\nHEIGHT 1\nPOINTS 5\n", "1 2 3\n");
  ASSERT_FALSE(fewer);
  EXPECT_EQ(fewer.error().kind, ErrorKind::input);
  const auto huge = cloud("WIDTH 4294967295\nHEIGHT 4294967295\nPOINTS 18446744065119617025\n", "1 2 3\n");
  EXPECT_FALSE(huge);
}

}  // namespace
}  // namespace rigcal
