#include "core/io/lvx_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/core/io/dump_bytes.h"
#include "tests/support/make_lvx.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct ReadAll {
  std::vector<std::size_t> devices;
  std::vector<std::uint64_t> frames;
  std::vector<Bytes> packets;
  LvxCounters counters;
  std::string truncation;
  std::string error;
};

ReadAll read_all(const Bytes& file) {
  ReadAll all;
  Expected<LvxReader> reader = LvxReader::open(write_bytes("a.lvx", file));
  if (!reader) {
    all.error = reader.error().message();
    return all;
  }
  for (LvxPackage package; reader->next(package);) {
    all.devices.push_back(package.device);
    all.frames.push_back(package.frame);
    all.packets.emplace_back(package.packet.begin(), package.packet.end());
  }
  all.counters = reader->counters();
  all.truncation = reader->truncation();
  return all;
}

LvxDevice device(const std::string& code, std::uint8_t index) {
  LvxDevice device;
  device.broadcast_code = code;
  device.index = index;
  device.type = 7;
  return device;
}

/// A sample packet of the data type, filled with `filling`.
Bytes packet(std::uint8_t type, std::uint8_t filling) {
  constexpr std::array<std::size_t, 9> sizes{1318, 918, 1362, 978, 1362, 786, 42, 1278, 678};
  Bytes bytes(sizes[type], filling);
  bytes[0] = 5;
  bytes[9] = type;
  return bytes;
}

/// Type 0 with all points at these millimetres.
Bytes wire_packet(std::array<std::int32_t, 3> millimetres) {
  Bytes bytes = packet(0, 33);
  for (std::size_t at = 18; at < bytes.size(); at += 13) std::memcpy(bytes.data() + at, millimetres.data(), 12);
  return bytes;
}

TEST(LvxReader, ReadsPackagesOfEveryTypeOfVersion1_1) {
  LvxBuilder lvx(1, {device("3JEDHC900100791", 0), device("0TFDG3B00600551", 1)});
  std::vector<Bytes> packets;
  for (std::uint8_t type = 0; type < 9; ++type) {
    packets.push_back(packet(type, type));
    lvx.add_package(type % 2, packets.back());
    if (type == 3 || type == 4) lvx.end_frame();
  }
  lvx.end_frame();
  lvx.end_frame();  // an empty one
  const ReadAll all = read_all(lvx.bytes());
  EXPECT_EQ(all.error, "");
  EXPECT_EQ(all.truncation, "");
  EXPECT_TRUE(all.packets == packets);
  EXPECT_THAT(all.devices, ElementsAre(0, 1, 0, 1, 0, 1, 0, 1, 0));
  EXPECT_THAT(all.frames, ElementsAre(0, 0, 0, 0, 1, 2, 2, 2, 2));
  EXPECT_EQ(all.counters.frames, 4U);
  EXPECT_TRUE(lvx_findings(all.counters).empty());
}

TEST(LvxReader, BeginsAsAFileOfTheVendorsRecorder) {
  LvxBuilder lvx(1, {device("a", 0), device("b", 1)});
  // The first bytes of a recording of the SDK's sample.
  const Bytes real{0x6C, 0x69, 0x76, 0x6F, 0x78, 0x5F, 0x74, 0x65, 0x63, 0x68, 0, 0, 0, 0, 0,
                   0,    1,    1,    0,    0,    0x67, 0xA7, 0x0E, 0xAC, 0x32, 0, 0, 0, 2};
  EXPECT_TRUE(std::equal(real.begin(), real.end(), lvx.bytes().begin()));
  EXPECT_EQ(lvx.bytes().size(), 29U + 2 * 59U);
  EXPECT_EQ(read_all(lvx.bytes()).truncation, "");
}

TEST(LvxReader, GivesTheMillimetresBackThatVersion1_0WasMadeFrom) {
  LvxBuilder lvx(0, {device("0TFDG3B00600551", 0)});
  std::vector<Bytes> packets;
  for (const std::int32_t far : {1, 12'345, 199'999, 299'997}) packets.push_back(wire_packet({far, -far, far / 2}));
  for (const Bytes& each : packets) lvx.add_package(0, each);
  lvx.end_frame();
  EXPECT_EQ(lvx.bytes().size(), 25U + 58U + 32U + 4 * 1319U);
  const ReadAll all = read_all(lvx.bytes());
  EXPECT_EQ(all.error, "");
  EXPECT_TRUE(all.packets == packets);
}

TEST(LvxReader, TurnsWhatIsNoNumberIntoASlotWithoutReturn) {
  LvxBuilder lvx(0, {device("a", 0)});
  lvx.add_package(0, wire_packet({1000, 2000, 3000}));
  lvx.end_frame();
  Bytes file = lvx.bytes();
  const std::size_t first = 25 + 58 + 32 + 1 + 18;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float huge = 1e30F;
  std::memcpy(file.data() + first, &nan, 4);
  std::memcpy(file.data() + first + 13 + 4, &huge, 4);
  const ReadAll all = read_all(file);
  ASSERT_EQ(all.packets.size(), 1U);
  EXPECT_TRUE(Bytes(all.packets[0].begin() + 18, all.packets[0].begin() + 30) == Bytes(12, 0));
  EXPECT_TRUE(Bytes(all.packets[0].begin() + 18 + 13 + 4, all.packets[0].begin() + 18 + 13 + 8) == Bytes(4, 0));
}

TEST(LvxReader, TellsTheDevices) {
  LvxDevice one = device("3JEDHC900100791", 4);
  one.has_extrinsics = true;
  one.roll_pitch_yaw_deg = {1.5F, -2.0F, 90.0F};
  one.translation_m = {0.1F, 0.2F, -0.3F};
  LvxBuilder lvx(1, {one, device(std::string("b\x01\xFF", 3), 9)});
  const Expected<LvxReader> reader = LvxReader::open(write_bytes("devices.lvx", lvx.bytes()));
  ASSERT_TRUE(reader);
  EXPECT_STREQ(reader->version(), "1.1");
  EXPECT_EQ(reader->frame_ns(), 50'000'000);
  ASSERT_EQ(reader->devices().size(), 2U);
  const LvxDevice& read = reader->devices()[0];
  EXPECT_EQ(read.broadcast_code, "3JEDHC900100791");
  EXPECT_EQ(read.index, 4);
  EXPECT_EQ(read.type, 7);
  EXPECT_TRUE(read.has_extrinsics);
  EXPECT_EQ(read.roll_pitch_yaw_deg, one.roll_pitch_yaw_deg);
  EXPECT_EQ(read.translation_m, one.translation_m);
  EXPECT_EQ(reader->devices()[1].broadcast_code, "b??");
  EXPECT_FALSE(reader->devices()[1].has_extrinsics);
}

TEST(LvxReader, NamesFilesThatItCannotRead) {
  Bytes good = LvxBuilder(1, {device("a", 0)}).bytes();
  EXPECT_THAT(read_all({}).error, HasSubstr("no .lvx file"));
  EXPECT_THAT(read_all(Bytes(100, 0x5A)).error, HasSubstr("no .lvx file"));
  for (std::size_t size = 16; size < good.size(); ++size) {
    EXPECT_THAT(read_all(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size))).error,
                HasSubstr("ends within the header"));
  }
  Bytes other = good;
  other[16] = 2;
  EXPECT_THAT(read_all(other).error, HasSubstr("has version 2.1"));
  other = good;
  other[28] = 0;
  EXPECT_THAT(read_all(other).error, HasSubstr("lists no devices"));
  other = good;
  other[27] = 0x80;
  EXPECT_THAT(read_all(other).error, HasSubstr("at byte 24: says that a frame lasts 2147483698 ms"));
  EXPECT_THAT(LvxReader::open(fresh_path("missing.lvx")).error().message(), HasSubstr("no such file"));
}

TEST(LvxReader, UsesACutFileUpToItsLastWholeFrame) {
  LvxBuilder lvx(1, {device("a", 0)});
  for (int frame = 0; frame < 3; ++frame) {
    lvx.add_package(0, packet(6, 1));
    lvx.add_package(0, packet(6, 2));
    lvx.end_frame();
  }
  const std::size_t frame_bytes = 24 + 2 * 43;
  for (std::size_t missing = 1; missing < 2 * frame_bytes; ++missing) {
    const ReadAll all = read_all(Bytes(lvx.bytes().begin(), lvx.bytes().end() - static_cast<std::ptrdiff_t>(missing)));
    const std::size_t whole = 2 - missing / frame_bytes;
    EXPECT_EQ(all.packets.size(), 2 * whole + (missing == frame_bytes ? 2 : 0));
    if (missing == frame_bytes) {
      EXPECT_EQ(all.truncation, "");  // exactly at the end of a frame
    } else {
      EXPECT_THAT(all.truncation, HasSubstr("after frame " + std::to_string(whole)));
    }
  }
}

TEST(LvxReader, GoesOnBehindADamagedFrame) {
  LvxBuilder lvx(1, {device("a", 0)});
  for (std::uint8_t frame = 0; frame < 2; ++frame) {
    lvx.add_package(0, packet(6, frame));
    lvx.add_package(7, packet(6, 2));  // a device that is not listed
    lvx.add_package(0, packet(6, frame));
    lvx.end_frame();
  }
  Bytes file = lvx.bytes();
  const std::size_t second_package = 29 + 59 + 24 + 43;
  file[second_package + 1 + 9] = 99;  // an unknown data type
  ReadAll all = read_all(file);
  EXPECT_EQ(all.truncation, "");
  EXPECT_THAT(all.frames, ElementsAre(0, 1, 1));
  EXPECT_THAT(lvx_findings(all.counters), ElementsAre(HasSubstr("1 of 2 frames are damaged"), HasSubstr("1 packages")));
  file[second_package + 1 + 9] = 2;  // longer than the frame
  EXPECT_EQ(read_all(file).counters.damaged_frames, 1U);
}

TEST(LvxReader, EndsWhereTheChainOfFramesBreaks) {
  LvxBuilder lvx(1, {device("a", 0)});
  for (int frame = 0; frame < 3; ++frame) {
    lvx.add_package(0, packet(6, 0));
    lvx.end_frame();
  }
  const std::size_t second = 29 + 59 + 24 + 43;
  const std::string place = "after frame 1, at byte " + std::to_string(second) + ": ";
  const std::vector<std::pair<std::size_t, std::string>> flips{{second, "no frame begins"},
                                                               {second + 8 + 7, "a frame is cut"}};
  for (const auto& [at, reason] : flips) {
    Bytes file = lvx.bytes();
    file[at] ^= 0xFF;
    const ReadAll all = read_all(file);
    EXPECT_EQ(all.packets.size(), 1U);
    EXPECT_THAT(all.truncation, HasSubstr(place + reason));
  }
  Bytes file = lvx.bytes();
  std::memset(file.data() + second + 8, 0, 8);
  EXPECT_THAT(read_all(file).truncation, HasSubstr(place + "a frame ends before it begins"));
}

}  // namespace
}  // namespace rigcal
