#include "core/io/ply_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "tests/core/io/dump_bytes.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

TEST(PlyFile, HasTheVerticesItsHeaderPromises) {
  const std::string path = fresh_path("cloud.ply");
  Expected<PlyWriter> writer = PlyWriter::create(path, "sensors: 0 avia");
  ASSERT_TRUE(writer);
  const std::vector<PlyPoint> points(70'000, PlyPoint{1.0F, 2.0F, 3.0F, 40, 1, {7, 8, 9}});
  writer->write(points);
  writer->write(std::span(points).first(1));
  ASSERT_TRUE(writer->finish());
  const Bytes bytes = read_bytes(path);
  const std::string text(bytes.begin(), bytes.end());
  const std::string end = "end_header\n";
  const std::size_t body = text.find(end) + end.size();
  const std::string header = text.substr(0, body);
  EXPECT_EQ(header.substr(0, 4), "ply\n");
  EXPECT_THAT(header, HasSubstr("\nformat binary_little_endian 1.0\n"));
  EXPECT_THAT(header, HasSubstr("\ncomment sensors: 0 avia\n"));
  EXPECT_THAT(header, HasSubstr("\nelement vertex 70001\ncomment ..."));
  EXPECT_EQ(header.find('\0'), std::string::npos);
  ASSERT_EQ(text.size() - body, 70'001U * 17U);
  float z = 0.0F;
  std::memcpy(&z, bytes.data() + body + std::size_t{17} * 70'000 + 8, sizeof(z));
  EXPECT_EQ(z, 3.0F);
  const Bytes rest(bytes.end() - 5, bytes.end());
  EXPECT_THAT(rest, testing::ElementsAre(7, 8, 9, 40, 1));
}

TEST(PlyFile, SaysThatTheDiskIsFull) {
  if (access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full here";
  Expected<PlyWriter> writer = PlyWriter::create("/dev/full");
  ASSERT_TRUE(writer) << writer.error().message();
  writer->write(std::vector<PlyPoint>(10));
  const Expected<void> written = writer->finish();
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message(), HasSubstr("disk is full"));
}

}  // namespace
}  // namespace rigcal
