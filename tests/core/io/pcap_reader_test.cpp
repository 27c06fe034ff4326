#include "core/io/pcap_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/core/io/read_dump.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

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
  const Bytes cooked_v1_vlan = join({Bytes(14, 0), {0x81, 0x00, 0, 5, 0x08, 0x00}, packet});
  const Bytes cooked_v2_vlan = join({{0x81, 0x00}, Bytes(18, 0), {0, 5, 0x08, 0x00}, packet});
  const std::vector<std::pair<std::uint32_t, Bytes>> variants{{1, ethernet(packet)},
                                                              {1, vlan},
                                                              {1, two_vlans},
                                                              {101, packet},
                                                              {228, packet},
                                                              {0, join({{2, 0, 0, 0}, packet})},
                                                              {0, join({{0, 0, 0, 2}, packet})},
                                                              {108, join({{0, 0, 0, 2}, packet})},
                                                              {113, cooked_v1},
                                                              {113, cooked_v1_vlan},
                                                              {276, cooked_v2},
                                                              {276, cooked_v2_vlan}};
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
  EXPECT_EQ(all.counters.not_udp, 2U);
  EXPECT_EQ(all.counters.ipv6, 1U);
  EXPECT_EQ(all.counters.parts.fragments, 2U);
  EXPECT_EQ(all.counters.parts.lost(), 1U);
  EXPECT_EQ(all.counters.malformed, 3U);
}

TEST(PcapReader, CountsPacketsCutByTheSnapshotLength) {
  Bytes frame = ethernet(ip_udp(Bytes(100, 7)));
  const auto whole = static_cast<std::uint32_t>(frame.size());
  for (const std::size_t snapped : {80U, 33U, 13U}) {  // within the payload, the IP header, the Ethernet header
    frame.resize(snapped);
    Bytes file =
        join({pcap_file(1, {}), number(0, 8, false), number(snapped, 4, false), number(whole, 4, false), frame});
    const ReadAll all = read_all(write_bytes("snap.pcap", file));
    EXPECT_EQ(all.counters.cut, 1U) << snapped;
    EXPECT_EQ(all.counters.malformed, 0U) << snapped;
    EXPECT_THAT(capture_findings(all.counters), testing::ElementsAre(HasSubstr("1 packet was cut short")));
  }
}

TEST(PcapReader, PutsFragmentsTogether) {
  Bytes payload_2(4000);
  for (std::size_t i = 0; i < payload_2.size(); ++i) payload_2[i] = static_cast<std::uint8_t>(i * 7);
  const std::vector<Bytes> parts = fragments(payload_2, 1480);
  ASSERT_EQ(parts.size(), 3U);
  const Bytes whole = ip_udp(payload);
  const ReadAll all = read_all(write_bytes(
      "parts.pcap", pcap_file(1, {ethernet(parts[2]), ethernet(whole), ethernet(parts[0]), ethernet(parts[1])})));
  ASSERT_EQ(all.payloads.size(), 2U);
  EXPECT_EQ(all.payloads[0], payload);
  EXPECT_TRUE(all.payloads[1] == payload_2);
  EXPECT_EQ(all.stamps_ns[1], start_ns + 3);
  EXPECT_EQ(all.counters.datagrams, 2U);
  EXPECT_EQ(all.counters.parts.whole, 1U);
  EXPECT_TRUE(capture_findings(all.counters).empty());
}

TEST(PcapReader, NamesFragmentsThatGiveNoPacket) {
  const std::vector<Bytes> parts = fragments(Bytes(4000, 1), 1480);
  const ReadAll all = read_all(write_bytes("lost.pcap", pcap_file(1, {ethernet(parts[2]), ethernet(parts[0])})));
  EXPECT_TRUE(all.payloads.empty());
  EXPECT_THAT(capture_findings(all.counters),
              testing::ElementsAre("1 fragmented packet could not be put together: 1 for want of parts"));
}

TEST(PcapReader, TakesPacketsWhoseLengthsAndChecksumsWereLeftToTheNetworkCard) {
  Bytes packet = ip_udp(payload);
  packet[2] = packet[3] = 0;       // total length
  packet[10] = packet[11] = 0xFF;  // IP checksum
  packet[26] = packet[27] = 0xFF;  // UDP checksum
  const ReadAll all = read_all(write_bytes("offload.pcap", pcap_file(1, {ethernet(packet)})));
  ASSERT_EQ(all.payloads.size(), 1U);
  EXPECT_EQ(all.payloads[0], payload);
}

TEST(PcapReader, TellsIpv6OfEveryLinkTypeFromIpv4) {
  const Bytes ipv6(40, 0x60);
  const std::vector<std::pair<std::uint32_t, Bytes>> variants{
      {1, ethernet(ipv6, 0x86DD)},
      {101, ipv6},
      {229, ipv6},
      {0, join({{10, 0, 0, 0}, ipv6})},
      {0, join({{0, 0, 0, 30}, ipv6})},
      {113, join({{0, 0, 0, 1, 0, 6, 1, 2, 3, 4, 5, 6, 0, 0, 0x86, 0xDD}, ipv6})},
      {276, join({{0x86, 0xDD, 0, 0, 0, 0, 0, 2, 0, 1, 0, 6, 1, 2, 3, 4, 5, 6, 0, 0}, ipv6})}};
  for (const auto& [link, frame] : variants) {
    EXPECT_EQ(read_all(write_bytes("ipv6.pcap", pcap_file(link, {frame}))).counters.ipv6, 1U) << link;
  }
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
  EXPECT_THAT(read_all(write_bytes("packed.pcap.gz", {0x1F, 0x8B, 8, 0})).error, HasSubstr("gunzip"));
  EXPECT_THAT(read_all(fresh_path("missing.pcap")).error, HasSubstr("no such file"));
  EXPECT_THAT(read_all(testing::TempDir()).error, HasSubstr("is a folder"));
  EXPECT_THAT(read_all(write_bytes("wifi.pcap", pcap_file(105, {payload}))).error, HasSubstr("link type 105 only"));
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

}  // namespace
}  // namespace rigcal
