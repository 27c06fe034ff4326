#include "core/io/pcap_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/io/pcapng_writer.h"
#include "tests/core/io/dump_bytes.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

struct ReadAll {
  std::vector<Bytes> payloads;
  std::vector<std::int64_t> stamps_ns;
  PcapCounters counters;
  std::string truncation;
  std::string error;
};

ReadAll read_all(const std::string& path) {
  ReadAll all;
  Expected<PcapReader> reader = PcapReader::open(path);
  if (!reader) {
    all.error = reader.error().message();
    return all;
  }
  Datagram datagram;
  while (true) {
    const Expected<bool> more = reader->next(datagram);
    if (!more) all.error = more.error().message();
    if (!more || !*more) break;
    EXPECT_EQ(to_string(datagram.from), "192.168.1.5:55000");
    EXPECT_EQ(to_string(datagram.to), "192.168.1.50:60001");
    all.payloads.emplace_back(datagram.bytes.begin(), datagram.bytes.end());
    all.stamps_ns.push_back(datagram.stamp_ns);
  }
  all.counters = reader->counters();
  all.truncation = reader->truncation();
  EXPECT_EQ(reader->truncated(), !all.truncation.empty());
  return all;
}

const Bytes payload{1, 2, 3, 4, 5};
constexpr std::int64_t start_ns = 1'600'000'000'000'000'000;

TEST(PcapReader, ReadsBothResolutionsAndByteOrders) {
  for (const bool nano : {true, false}) {
    for (const bool big : {true, false}) {
      const std::vector<Bytes> frames{ethernet(ip_udp(payload)), ethernet(ip_udp({9}))};
      const ReadAll all = read_all(write_bytes("order.pcap", pcap_file(1, frames, nano, big)));
      EXPECT_EQ(all.error, "");
      ASSERT_EQ(all.payloads.size(), 2U);
      EXPECT_EQ(all.payloads[0], payload);
      EXPECT_EQ(all.payloads[1], Bytes{9});
      EXPECT_EQ(all.stamps_ns[1], start_ns + (nano ? 1 : 1000));
      EXPECT_EQ(all.truncation, "");
    }
  }
}

TEST(PcapReader, ReadsEveryLinkType) {
  const Bytes packet = ip_udp(payload);
  const Bytes vlan = ethernet(join({{0, 5, 0x08, 0x00}, packet}), 0x8100);
  const Bytes two_vlans = ethernet(join({{0, 5, 0x81, 0x00, 0, 6, 0x08, 0x00}, packet}), 0x88A8);
  const Bytes cooked_v1 = join({{0, 0, 0, 1, 0, 6, 1, 2, 3, 4, 5, 6, 0, 0, 0x08, 0x00}, packet});
  const Bytes cooked_v2 = join({{0x08, 0x00, 0, 0, 0, 0, 0, 2, 0, 1, 0, 6, 1, 2, 3, 4, 5, 6, 0, 0}, packet});
  const std::vector<std::pair<std::uint32_t, Bytes>> variants{{1, ethernet(packet)},
                                                              {1, vlan},
                                                              {1, two_vlans},
                                                              {101, packet},
                                                              {228, packet},
                                                              {0, join({{2, 0, 0, 0}, packet})},
                                                              {108, join({{0, 0, 0, 2}, packet})},
                                                              {113, cooked_v1},
                                                              {276, cooked_v2}};
  for (const auto& [link, frame] : variants) {
    const ReadAll all = read_all(write_bytes("link.pcap", pcap_file(link, {frame})));
    EXPECT_EQ(all.error, "") << link;
    ASSERT_EQ(all.payloads.size(), 1U) << link;
    EXPECT_EQ(all.payloads[0], payload) << link;
  }
}

TEST(PcapReader, IgnoresEthernetPadding) {
  Bytes frame = ethernet(ip_udp(payload));
  frame.resize(60, 0xEE);
  const ReadAll all = read_all(write_bytes("padding.pcap", pcap_file(1, {frame})));
  ASSERT_EQ(all.payloads.size(), 1U);
  EXPECT_EQ(all.payloads[0], payload);
}

TEST(PcapReader, CountsWhatItLeavesOut) {
  Bytes lying_udp_length = ip_udp(payload);
  lying_udp_length[25] = 200;
  const Bytes ip_with_options_missing = {0x4F, 0, 0, 28, 0, 0, 0, 0, 64, 17, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2};
  const std::vector<Bytes> frames{ethernet(ip_udp(payload)),         ethernet({0, 1}, 0x0806),  // ARP
                                  ethernet(Bytes(40, 0x60), 0x86DD),                            // IPv6
                                  ethernet(ip_udp(payload, 0, 6)),                              // TCP
                                  ethernet(ip_udp(payload, 0x2000)),                            // first fragment
                                  ethernet(ip_udp(payload, 0x00B9)),                            // last fragment
                                  ethernet(lying_udp_length),        ethernet(ip_with_options_missing), {1, 2, 3}};
  const ReadAll all = read_all(write_bytes("others.pcap", pcap_file(1, frames)));
  EXPECT_EQ(all.counters.frames, 9U);
  EXPECT_EQ(all.counters.datagrams, 1U);
  EXPECT_EQ(all.counters.not_udp, 3U);
  EXPECT_EQ(all.counters.fragments, 2U);
  EXPECT_EQ(all.counters.malformed, 3U);
}

TEST(PcapReader, CountsFramesCutByTheSnapshotLengthAsMalformed) {
  Bytes frame = ethernet(ip_udp(Bytes(100, 7)));
  frame.resize(80);
  EXPECT_EQ(read_all(write_bytes("snap.pcap", pcap_file(1, {frame}))).counters.malformed, 1U);
}

TEST(PcapReader, DeliversWhatIsWholeOfACutDump) {
  const Bytes whole = pcap_file(1, {ethernet(ip_udp(payload)), ethernet(ip_udp(payload))});
  for (const std::size_t missing : {1U, 40U, 50U}) {  // within the last frame, and within its header
    const Bytes cut(whole.begin(), whole.end() - static_cast<std::ptrdiff_t>(missing));
    const ReadAll all = read_all(write_bytes("cut.pcap", cut));
    EXPECT_EQ(all.error, "");
    EXPECT_EQ(all.payloads.size(), 1U);
    EXPECT_THAT(all.truncation, HasSubstr("after frame 1"));
  }
}

TEST(PcapReader, NamesFilesThatAreNoDumps) {
  EXPECT_THAT(read_all(write_bytes("empty.pcap", {})).error, HasSubstr("is empty"));
  EXPECT_THAT(read_all(write_bytes("noise.pcap", Bytes(1000, 0x5A))).error, HasSubstr("no packet dump"));
  EXPECT_THAT(read_all(write_bytes("head.pcap", {0xD4, 0xC3, 0xB2, 0xA1, 2})).error, HasSubstr("ends within"));
  EXPECT_THAT(read_all(fresh_path("missing.pcap")).error, HasSubstr("no such file"));
  EXPECT_THAT(read_all(testing::TempDir()).error, HasSubstr("is a folder"));
  EXPECT_THAT(read_all(write_bytes("wifi.pcap", pcap_file(105, {payload}))).error, HasSubstr("IEEE802_11"));
}

TEST(PcapReader, SaysThatItMayNotRead) {
  if (geteuid() == 0) GTEST_SKIP() << "root may read everything";
  const std::string path = write_bytes("secret.pcap", pcap_file(1, {}));
  chmod(path.c_str(), 0);
  EXPECT_THAT(read_all(path).error, HasSubstr("no permission"));
}

TEST(PcapReader, DamageBeforeTheFirstFrameIsAnError) {
  const Bytes head = pcap_file(1, {});
  EXPECT_EQ(read_all(write_bytes("none.pcap", head)).error, "");
  EXPECT_THAT(read_all(write_bytes("damaged.pcap", join({head, Bytes(16, 0xFF)}))).error, HasSubstr("no whole packet"));
}

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
  ASSERT_TRUE(writer->write({start_ns, {{192, 168, 1, 5}, 55000}, {{192, 168, 1, 50}, 60001}, payload}));
  ASSERT_TRUE(writer->close());
  const std::string command = "tshark -n -o ip.check_checksum:TRUE -r '" + path +
                              "' -Y 'ip.checksum.status == \"Good\" && udp.length == 13' -T fields -e udp.dstport "
                              "2>/dev/null | grep -qx 60001";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

}  // namespace
}  // namespace rigcal
