#include "core/io/pcapng_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

#include "tests/core/io/read_dump.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

TEST(PcapngWriter, WritesWhatTheReaderReads) {
  const std::string path = fresh_path("written.pcapng");
  Expected<PcapngWriter> writer = PcapngWriter::create(path);
  ASSERT_TRUE(writer);
  std::vector<Bytes> payloads;
  Datagram datagram{start_ns + 123'456'789, {{192, 168, 1, 5}, 55000}, {{192, 168, 1, 50}, 60001}, {}};
  for (const std::size_t size : {0U, 1U, 2U, 3U, 1362U, 65507U}) {
    payloads.emplace_back(size, static_cast<std::uint8_t>(size));
    datagram.bytes = payloads.back();
    ++datagram.stamp_ns;
    ASSERT_TRUE(writer->write(datagram));
  }
  // More than the buffer holds.
  for (int i = 0; i < 40; ++i) {
    payloads.push_back(payloads[5]);
    datagram.bytes = payloads.back();
    ++datagram.stamp_ns;
    ASSERT_TRUE(writer->write(datagram));
  }
  EXPECT_EQ(writer->datagrams(), payloads.size());
  ASSERT_TRUE(writer->close());
  EXPECT_EQ(writer->bytes(), std::filesystem::file_size(path));
  const ReadAll all = read_all(path);
  EXPECT_EQ(all.error, "");
  EXPECT_EQ(all.truncation, "");
  EXPECT_EQ(all.payloads, payloads);
  EXPECT_EQ(all.stamps_ns.front(), start_ns + 123'456'790);
  EXPECT_EQ(all.stamps_ns.back(), datagram.stamp_ns);
}

TEST(PcapngWriter, WritesARightIpChecksum) {
  const std::string path = fresh_path("checksum.pcapng");
  Expected<PcapngWriter> writer = PcapngWriter::create(path);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->write({start_ns, {{192, 168, 1, 5}, 55000}, {{192, 168, 1, 50}, 60001}, payload}));
  ASSERT_TRUE(writer->close());
  const Bytes file = read_bytes(path);
  const std::size_t ip = file.size() - 4 - 3 - 33;  // trailing length, padding, packet
  ASSERT_EQ(file[ip], 0x45);
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < 20; i += 2) sum += static_cast<std::uint32_t>(file[ip + i] << 8) | file[ip + i + 1];
  EXPECT_EQ((sum & 0xFFFF) + (sum >> 16), 0xFFFFU);  // RFC 1071: with the checksum in place the sum is all ones
}

TEST(PcapngWriter, ReadsUpToTheLastWholeBlockAfterAPowerCut) {
  const std::string path = fresh_path("power.pcapng");
  Expected<PcapngWriter> writer = PcapngWriter::create(path);
  ASSERT_TRUE(writer);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(writer->write({start_ns, {{192, 168, 1, 5}, 55000}, {{192, 168, 1, 50}, 60001}, payload}));
  }
  ASSERT_TRUE(writer->close());
  const Bytes whole = read_bytes(path);
  const Bytes cut(whole.begin(), whole.end() - 10);
  EXPECT_EQ(read_all(write_bytes("cut.pcapng", cut)).payloads.size(), 2U);
  // Some file systems leave zeros where the last writes should be.
  const ReadAll zeros = read_all(write_bytes("zeros.pcapng", join({whole, Bytes(4096, 0)})));
  EXPECT_EQ(zeros.payloads.size(), 3U);
  EXPECT_THAT(zeros.truncation, HasSubstr("after frame 3"));
}

TEST(PcapngWriter, RefusesWhatCannotBeStored) {
  Expected<PcapngWriter> writer = PcapngWriter::create(fresh_path("refuse.pcapng"));
  ASSERT_TRUE(writer);
  const Bytes long_payload(65508);
  EXPECT_FALSE(writer->write({start_ns, {}, {}, long_payload}));
  EXPECT_FALSE(writer->write({-1, {}, {}, payload}));
  EXPECT_EQ(writer->datagrams(), 0U);
}

TEST(PcapngWriter, SaysWhereItCannotWrite) {
  const Expected<PcapngWriter> writer = PcapngWriter::create(testing::TempDir() + "/no_such_folder/a.pcapng");
  ASSERT_FALSE(writer);
  EXPECT_EQ(writer.error().kind, ErrorKind::system);
  EXPECT_THAT(writer.error().message(), HasSubstr("folder does not exist"));
}

TEST(PcapngWriter, SaysThatTheDiskIsFull) {
  if (access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full here";
  Expected<PcapngWriter> writer = PcapngWriter::create("/dev/full");
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->write({start_ns, {}, {}, payload}));  // still in the buffer
  const Expected<void> flushed = writer->flush();
  ASSERT_FALSE(flushed);
  EXPECT_EQ(flushed.error().kind, ErrorKind::system);
  EXPECT_THAT(flushed.error().message(), HasSubstr("disk is full"));
}

TEST(PcapngWriter, OpensInTshark) {
  if (std::system("command -v tshark >/dev/null 2>&1") != 0) GTEST_SKIP() << "tshark is not installed";
  const std::string path = fresh_path("tshark.pcapng");
  Expected<PcapngWriter> writer = PcapngWriter::create(path);
  ASSERT_TRUE(writer);
  const Endpoint from{{192, 168, 1, 5}, 55000};
  const Endpoint to{{192, 168, 1, 50}, 60001};
  ASSERT_TRUE(writer->write({start_ns + 123'456'789, from, to, payload}));
  ASSERT_TRUE(writer->write({start_ns + 123'456'790, from, to, Bytes{0xFF}}));
  ASSERT_TRUE(writer->close());
  const std::string out = fresh_path("tshark.txt");
  const std::string command =
      "tshark -n -o ip.check_checksum:TRUE -r '" + path +
      "' -T fields -E separator=/s -e frame.time_epoch -e ip.src -e udp.srcport -e ip.dst -e udp.dstport -e udp.length"
      " -e udp.payload -e ip.checksum.status > '" +
      out + "' 2>/dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const Bytes text = read_bytes(out);
  EXPECT_EQ(std::string(text.begin(), text.end()),
            "1600000000.123456789 192.168.1.5 55000 192.168.1.50 60001 13 0102030405 1\n"
            "1600000000.123456790 192.168.1.5 55000 192.168.1.50 60001 9 ff 1\n");
}

}  // namespace
}  // namespace rigcal
