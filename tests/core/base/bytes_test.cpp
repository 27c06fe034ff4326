#include "core/base/bytes.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

TEST(ByteReader, ReadsLittleEndianWhatTheWriterWrote) {
  std::vector<std::uint8_t> bytes;
  ByteWriter writer(bytes);
  writer.write<std::uint16_t>(0x1234);
  writer.write<std::int32_t>(-5);
  writer.write<float>(1.5F);
  EXPECT_EQ(bytes[0], 0x34);
  ByteReader reader(bytes);
  EXPECT_EQ(reader.read<std::uint16_t>(), 0x1234);
  EXPECT_EQ(reader.read<std::int32_t>(), -5);
  EXPECT_EQ(reader.read<float>(), 1.5F);
  EXPECT_TRUE(reader.ok());
  EXPECT_EQ(reader.left(), 0U);
}

TEST(ByteReader, PastTheEndGivesZeroAndStaysBad) {
  const std::vector<std::uint8_t> bytes{1, 2, 3};
  ByteReader reader(bytes);
  EXPECT_EQ(reader.read<std::uint32_t>(), 0U);
  EXPECT_FALSE(reader.ok());
  EXPECT_EQ(reader.read<std::uint8_t>(), 0);
  EXPECT_FALSE(reader.ok());
}

}  // namespace
}  // namespace rigcal
