#include "apps/capture/packet_recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "apps/recording/datagram_file.h"
#include "core/io/session_folder.h"
#include "core/io/session_lock.h"
#include "drivers/livox_codec/discovery.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

namespace fs = std::filesystem;

class Recorder : public testing::Test {
 protected:
  Expected<PacketRecorder> record(std::uint64_t keep_bytes, int packets) const {
    auto recorder = PacketRecorder::create(session.string(), keep_bytes);
    EXPECT_TRUE(recorder.has_value());
    const auto hello = livox::make_broadcast({"3JEDHC900100791", livox::DeviceType::avia, 0}, 1);
    EXPECT_TRUE(recorder->write({1, {{127, 0, 0, 179}, 65000}, {{127, 0, 0, 1}, 55000}, hello}).has_value());
    std::vector<std::uint8_t> bytes(1300, 5);
    for (int i = 0; i < packets; ++i) {
      bytes[0] = static_cast<std::uint8_t>(i);
      EXPECT_TRUE(recorder->write({100 + i, {{127, 0, 0, 179}, 60001}, {{127, 0, 0, 1}, 56001}, bytes}).has_value());
    }
    return recorder;
  }
  struct Read {
    std::vector<std::int64_t> packets;  ///< Stamps.
    int broadcasts = 0;
    std::string truncation;
    std::uint64_t frames = 0;
  };
  Read read() const {
    Read read;
    auto file = open_datagrams(session_packets_path(session.string()));
    EXPECT_TRUE(file.has_value());
    if (!file) return read;
    Datagram datagram;
    while (*(*file)->next(datagram)) {
      if (datagram.from.port == 65000) ++read.broadcasts;
      if (datagram.from.port == 60001) read.packets.push_back(datagram.stamp_ns);
    }
    read.truncation = (*file)->truncation();
    read.frames = (*file)->notes().frames->frames;
    EXPECT_NEAR((*file)->fraction(), 1.0, 0.1);
    return read;
  }
  fs::path session = scratch_folder("recorder");
};

TEST_F(Recorder, KeepsAllWhereNotToldOtherwise) {
  auto recorder = record(0, 1000);
  ASSERT_TRUE(recorder->close().has_value());
  EXPECT_EQ(recorder->datagrams(), 1001U);
  EXPECT_FALSE(recorder->forgotten_until_ns().has_value());
  const Read all = read();
  EXPECT_EQ(all.packets.size(), 1000U);
  EXPECT_EQ(all.broadcasts, 1);
  EXPECT_EQ(session_packet_parts(session_packets_path(session.string())).size(), 1U);
}

TEST_F(Recorder, HasTheSessionForItselfUntilItIsGone) {
  {
    auto recorder = record(PacketRecorder::kLeastKept, 5000);  // Some parts.
    EXPECT_FALSE(SessionLock::take(session.string()));
    const PacketRecorder taken = *std::move(recorder);
    EXPECT_FALSE(SessionLock::take(session.string()));
  }
  EXPECT_TRUE(SessionLock::take(session.string()));
  auto recorder = record(0, 10);
  EXPECT_TRUE(recorder->close().has_value());
  EXPECT_FALSE(SessionLock::take(session.string())) << "tables and session.json are still to be written";
}

TEST_F(Recorder, KeepsTheNewestAndWhoItIsFrom) {
  constexpr int packets = 40'000;  // 54 MB
  auto recorder = record(PacketRecorder::kLeastKept, packets);
  ASSERT_TRUE(recorder->close().has_value());
  EXPECT_EQ(recorder->datagrams(), static_cast<std::uint64_t>(packets + 1));
  std::uint64_t on_disk = 0;
  for (const auto& entry : fs::directory_iterator(session)) on_disk += entry.file_size();
  EXPECT_EQ(on_disk, recorder->bytes());
  EXPECT_LE(on_disk, PacketRecorder::kLeastKept);
  EXPECT_GE(on_disk, PacketRecorder::kLeastKept * 6 / 8);
  const Read kept = read();
  // Without a hole up to the end, and each part begins with the broadcast.
  ASSERT_FALSE(kept.packets.empty());
  EXPECT_EQ(kept.packets.back(), 100 + packets - 1);
  EXPECT_EQ(kept.packets.back() - kept.packets.front() + 1, static_cast<std::int64_t>(kept.packets.size()));
  EXPECT_EQ(*recorder->forgotten_until_ns() + 1, kept.packets.front());
  EXPECT_EQ(kept.broadcasts, 8);
  EXPECT_THAT(kept.truncation, IsEmpty());
  EXPECT_EQ(kept.frames, kept.packets.size() + 8);
}

TEST_F(Recorder, APowerCutBetweenPartsLeavesThoseBefore) {
  ASSERT_TRUE(record(PacketRecorder::kLeastKept, 5000)->close().has_value());
  const std::string newest = session_packets_path(session.string());
  std::ofstream(newest, std::ios::trunc).close();
  const Read cut = read();
  EXPECT_GT(cut.packets.size(), 1000U);
  EXPECT_THAT(cut.truncation, HasSubstr("ends before its last part"));
  fs::remove(newest);
  EXPECT_EQ(read().packets.size(), cut.packets.size());
  EXPECT_EQ(read().frames, cut.frames);  // Each counted once.
}

TEST_F(Recorder, APowerCutBeforeTheNewestPartsFirstPacketLeavesThoseBefore) {
  ASSERT_TRUE(record(PacketRecorder::kLeastKept, 5000)->close().has_value());
  const std::string newest = session_packets_path(session.string());
  const fs::path aside = session / "aside";
  fs::rename(newest, aside);
  const Read whole = read();
  for (const std::uintmax_t bytes : {std::uintmax_t{40}, std::uintmax_t{60}, std::uintmax_t{120}}) {
    fs::copy_file(aside, newest, fs::copy_options::overwrite_existing);
    fs::resize_file(newest, bytes);
    const Read cut = read();
    EXPECT_EQ(cut.packets, whole.packets) << bytes;
    EXPECT_EQ(cut.frames, whole.frames) << bytes;
    EXPECT_THAT(cut.truncation, HasSubstr("ends before its last part: has no whole packet")) << bytes;
  }
}

TEST_F(Recorder, AsksForNoMemoryWhileItRecords) {
  auto recorder = record(0, 100);
  const std::vector<std::uint8_t> bytes(1300, 5);
  bool is_written = true;
  const std::uint64_t before = allocations_in_this_thread();
  for (int i = 0; i < 5000; ++i) {
    const auto written = recorder->write({1000 + i, {{127, 0, 0, 179}, 60001}, {{127, 0, 0, 1}, 56001}, bytes});
    const auto handed_over = i % 100 == 0 ? recorder->hand_over() : Expected<void>();
    is_written = is_written && written.has_value() && handed_over.has_value();
  }
  EXPECT_EQ(allocations_in_this_thread() - before, 0U);
  EXPECT_TRUE(is_written);
  EXPECT_TRUE(recorder->close().has_value());
}

TEST_F(Recorder, SaysThatItsFileIsGone) {
  auto recorder = record(0, 100);
  EXPECT_TRUE(recorder->flush().has_value());
  fs::remove(session_packets_path(session.string()));
  const auto flushed = recorder->flush();
  ASSERT_FALSE(flushed.has_value());
  EXPECT_EQ(flushed.error().kind, ErrorKind::system);
  EXPECT_THAT(flushed.error().message(), HasSubstr("lidar.pcapng: was removed"));
}

TEST_F(Recorder, OtherFilesAreNoParts) {
  ASSERT_TRUE(record(0, 10)->close().has_value());
  for (const char* name : {"lidar.00001.pcapng", "lidar.0000x1.pcapng", "lidar.000001.pcap", "other.000001.pcapng"})
    std::ofstream(session / name) << "no packets";
  EXPECT_EQ(read().packets.size(), 10U);
}

}  // namespace
}  // namespace rigcal
