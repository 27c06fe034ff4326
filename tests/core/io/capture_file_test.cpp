#include "core/io/capture_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/io/read_dump.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

// Blocks of pcapng written down from the specification, in both byte orders.
class Blocks {
 public:
  explicit Blocks(bool big) : big_(big) {}

  [[nodiscard]] Bytes u16(std::uint64_t value) const { return number(value, 2, big_); }
  [[nodiscard]] Bytes u32(std::uint64_t value) const { return number(value, 4, big_); }
  [[nodiscard]] Bytes block(std::uint32_t type, Bytes body) const {
    body.resize((body.size() + 3) / 4 * 4);
    const Bytes size = u32(12 + body.size());
    return join({u32(type), size, body, size});
  }
  [[nodiscard]] Bytes section() const {
    return block(0x0A0D0D0A, join({u32(0x1A2B3C4D), u16(1), u16(0), Bytes(8, 0xFF)}));
  }
  /// `resolution` as in if_tsresol, 0 for none given.
  [[nodiscard]] Bytes interface(std::uint16_t link, std::uint8_t resolution = 0, std::int64_t offset_s = 0) const {
    Bytes body = join({u16(link), u16(0), u32(0)});
    body = join({body, u16(2), u16(3), {'e', 't', 'h', 0}});  // if_name, to be skipped
    if (resolution != 0) body = join({body, u16(9), u16(1), {resolution, 0, 0, 0}});
    if (offset_s != 0) {
      body = join({body, u16(14), u16(8), number(static_cast<std::uint64_t>(offset_s), 8, big_)});
    }
    return block(1, join({body, u16(0), u16(0)}));
  }
  [[nodiscard]] Bytes packet(std::uint32_t interface, std::uint64_t ticks, const Bytes& frame) const {
    return block(6, join({u32(interface), u32(ticks >> 32), u32(ticks), u32(frame.size()), u32(frame.size()), frame}));
  }

 private:
  bool big_;
};

const Bytes frame = ethernet(ip_udp(payload));

TEST(CaptureFile, ReadsInterfacesWithTheirOwnLinkTypeResolutionAndOffset) {
  for (const bool big : {false, true}) {
    const Blocks b(big);
    const Bytes cooked = join({{0x08, 0x00}, Bytes(18, 0), ip_udp(payload)});
    const Bytes file =
        join({b.section(), b.interface(1), b.interface(276, 9), b.interface(101, 0x80 | 10, 1'000), b.interface(1, 12),
              b.packet(0, 1'600'000'000'000'001, frame), b.packet(1, 1'600'000'000'000'000'002, cooked),
              b.packet(2, (1'599'999'000ULL << 10U) | 512U, ip_udp(payload)),
              b.packet(3, 1'600'000'000'000'003'999ULL, frame)});
    const ReadAll all = read_all(write_bytes("interfaces.pcapng", file));
    EXPECT_EQ(all.error, "");
    EXPECT_EQ(all.truncation, "");
    // The last has picoseconds: 1600 s since 1970.
    EXPECT_THAT(all.stamps_ns,
                testing::ElementsAre(start_ns + 1'000, start_ns + 2, start_ns + 500'000'000, 1'600'000'000'000'003));
    for (const Bytes& each : all.payloads) EXPECT_EQ(each, payload);
  }
}

TEST(CaptureFile, ReadsFineBinaryResolutionsToTheNanosecond) {
  const Blocks b(false);
  const std::uint64_t ticks = (1'600'000'000ULL << 32U) | (1ULL << 31U);
  const Bytes file = join({b.section(), b.interface(1, 0x80 | 32), b.interface(1, 0x80 | 40), b.packet(0, ticks, frame),
                           b.packet(1, (1'600'000ULL << 40U) | (3ULL << 38U), frame)});
  const ReadAll all = read_all(write_bytes("binary.pcapng", file));
  EXPECT_THAT(all.stamps_ns, testing::ElementsAre(start_ns + 500'000'000, 1'600'000'750'000'000));
}

TEST(CaptureFile, ReadsSectionsOfBothByteOrdersAndSkipsOtherBlocks) {
  const Blocks little(false);
  const Blocks big(true);
  const Bytes old = little.block(2, join({little.u16(0), little.u16(7), little.u32(0), little.u32(5),
                                          little.u32(frame.size()), little.u32(frame.size()), frame}));
  const Bytes file = join({little.section(), little.interface(1), little.block(5, Bytes(100, 1)),
                           little.packet(0, 1, frame), little.block(0x0BAD, Bytes(500'000, 2)), old, big.section(),
                           big.interface(101), big.packet(0, 2, ip_udp({7}))});
  const ReadAll all = read_all(write_bytes("sections.pcapng", file));
  EXPECT_EQ(all.truncation, "");
  EXPECT_THAT(all.stamps_ns, testing::ElementsAre(1'000, 5'000, 2'000));
  EXPECT_EQ(all.payloads.back(), Bytes{7});
}

TEST(CaptureFile, CountsWhatHasNoStampNoInterfaceOrABrokenRecord) {
  const Blocks b(false);
  Bytes broken = b.packet(0, 1, frame);
  broken[20 + 0] = 0xFF;  // the captured length is more than the block holds
  const Bytes file = join({b.section(), b.interface(1), b.interface(1, 0x80 | 100), b.interface(105),
                           b.block(3, join({b.u32(frame.size()), frame})), b.packet(9, 1, frame), broken,
                           b.packet(1, 1, frame), b.packet(2, 1, frame), b.packet(0, 1, frame)});
  const ReadAll all = read_all(write_bytes("broken.pcapng", file));
  EXPECT_EQ(all.error, "");
  EXPECT_EQ(all.counters.frames, 6U);
  EXPECT_EQ(all.counters.malformed, 4U);
  EXPECT_EQ(all.counters.other_link, 1U);
  EXPECT_EQ(all.counters.datagrams, 1U);
  EXPECT_THAT(capture_findings(all.counters), testing::ElementsAre(HasSubstr("contradict"), HasSubstr("link type")));
}

TEST(CaptureFile, NamesTheOffsetOfDamage) {
  const Blocks b(false);
  const Bytes good = join({b.section(), b.interface(1), b.packet(0, 1, frame)});
  const std::string place = "at byte " + std::to_string(good.size());
  const std::vector<std::pair<Bytes, std::string>> endings{
      {b.u32(6), "header of a block is cut"},
      {join({b.u32(6), b.u32(13)}), "the length 13"},
      {join({b.u32(6), b.u32(8)}), "the length 8"},
      {join({b.u32(6), b.u32(0x7FFFFFF0)}), "claims 2147483632 bytes"},
      {join({b.u32(5), b.u32(0xFFFFFFF0)}), "a block is cut"},
      {join({b.u32(5), b.u32(16), b.u32(0), b.u32(20)}), "two lengths"},
      {join({b.u32(0x0A0D0D0A), b.u32(28), Bytes(20, 1)}), "section header is no such"},
      {join({b.u32(0x0A0D0D0A), b.u32(28)}), "section header is cut"},
      {b.block(0x0A0D0D0A, join({b.u32(0x1A2B3C4D), b.u16(2), b.u16(0), Bytes(8, 0xFF)})), "unknown version 2"},
      {b.block(1, b.u32(1)), "interface is no such"}};
  for (const auto& [ending, text] : endings) {
    const ReadAll all = read_all(write_bytes("damage.pcapng", join({good, ending})));
    EXPECT_EQ(all.payloads.size(), 1U);
    EXPECT_THAT(all.truncation, HasSubstr(place));
    EXPECT_THAT(all.truncation, HasSubstr(text));
  }
}

TEST(CaptureFile, SetsABoundToInterfaces) {
  const Blocks b(false);
  std::vector<Bytes> blocks(5000, b.block(1, Bytes(8, 0)));
  blocks[0] = b.section();
  EXPECT_THAT(read_all(write_bytes("many.pcapng", join(blocks))).error, HasSubstr("interface"));
}

TEST(CaptureFile, ReadsAFrameThatClaimsTooMuchAsDamage) {
  const Bytes file = join({pcap_file(1, {frame}), Bytes(8, 0), number(262'145, 4, false), number(262'145, 4, false)});
  EXPECT_THAT(read_all(write_bytes("claim.pcap", file)).truncation, HasSubstr("claims 262145 bytes"));
}

TEST(InputFile, ReadsAcrossItsBufferAndTellsWhereItIs) {
  Bytes bytes(3'000'000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 31 >> 3);
  Expected<InputFile> file = InputFile::open(write_bytes("long.bin", bytes));
  ASSERT_TRUE(file);
  EXPECT_EQ(file->size(), bytes.size());
  std::size_t at = 0;
  for (const std::size_t size : {0U, 1U, 999'999U, 1'500'000U, 7U}) {
    EXPECT_EQ(file->offset(), at);
    const ByteView view = file->take(size);
    ASSERT_EQ(view.size(), size);
    EXPECT_TRUE(std::equal(view.begin(), view.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at)));
    at += size;
  }
  EXPECT_TRUE(file->skip(400'000));
  EXPECT_EQ(file->peek(1)[0], bytes[at + 400'000]);
  EXPECT_EQ(file->take(std::size_t{1} << 40U).size(), bytes.size() - at - 400'000);
  EXPECT_FALSE(file->skip(1));
  EXPECT_EQ(file->offset(), bytes.size());
  EXPECT_EQ(file->failure(), "");
}

}  // namespace
}  // namespace rigcal
