#include "core/io/pcd_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lzf.h>
#include <sys/stat.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/random.h"
#include "tests/core/io/dump_bytes.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

std::string error_of(const std::string& path) {
  const Expected<PcdCloud> cloud = read_pcd(path);
  return cloud ? std::string("no error") : cloud.error().message();
}

Bytes text_bytes(const std::string& text) { return Bytes(text.begin(), text.end()); }

template <class T>
void append(Bytes& bytes, T value) {
  const auto* at = reinterpret_cast<const std::uint8_t*>(&value);
  bytes.insert(bytes.end(), at, at + sizeof(T));
}

std::string header(const std::string& fields, const std::string& size, const std::string& type,
                   const std::string& points, const std::string& data) {
  return "# .PCD v.7 - Point Cloud Data file format\nVERSION .7\nFIELDS " + fields + "\nSIZE " + size + "\nTYPE " +
         type + "\nWIDTH " + points + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA " + data + "\n";
}

std::vector<Point> random_points(std::size_t count) {
  Random random(7);
  std::vector<Point> points(count);
  for (Point& point : points) {
    point.x = static_cast<float>(random.normal());
    point.y = static_cast<float>(random.normal());
    point.z = static_cast<float>(random.normal());
    point.reflectivity = static_cast<std::uint8_t>(random.below(256));
    point.tag = static_cast<std::uint8_t>(random.below(256));
  }
  return points;
}

void expect_equal(const std::vector<Point>& a, const std::vector<Point>& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(Point)), 0);
}

TEST(PcdFile, ReadsBackToTheBitWhatItWrote) {
  const std::vector<Point> points = random_points(100'003);  // no multiple of any chunk
  const std::string path = fresh_path("round.pcd");
  ASSERT_TRUE(write_pcd(path, points));
  const Expected<PcdCloud> cloud = read_pcd(path);
  ASSERT_TRUE(cloud) << cloud.error().message();
  expect_equal(cloud->points, points);
  EXPECT_EQ(cloud->summary.points, points.size());
  EXPECT_TRUE(cloud->summary.has_reflectivity);
  EXPECT_FALSE(cloud->summary.has_ring);
  EXPECT_FALSE(cloud->summary.size_missing);
}

TEST(PcdFile, WritesAnEmptyCloud) {
  const std::string path = fresh_path("none.pcd");
  ASSERT_TRUE(write_pcd(path, {}));
  const Expected<PcdCloud> cloud = read_pcd(path);
  ASSERT_TRUE(cloud);
  EXPECT_TRUE(cloud->points.empty());
}

TEST(PcdFile, ReadsAsciiInAnyOrderOfFields) {
  const std::string path =
      write_text("order.pcd", header("intensity z ring x y t", "4 4 2 8 4 8", "F F U F F F", "3", "ascii") +
                                  "12.6 3 5 1 2 0.5\n+300 -3.5e0 65535 1e-1 .25 0\r\n\n-7 1 0 1 1 0\n");
  const Expected<PcdCloud> cloud = read_pcd(path);
  ASSERT_TRUE(cloud) << cloud.error().message();
  ASSERT_EQ(cloud->points.size(), 3U);
  const Point& first = cloud->points[0];
  EXPECT_EQ(first.x, 1.0F);
  EXPECT_EQ(first.y, 2.0F);
  EXPECT_EQ(first.z, 3.0F);
  EXPECT_EQ(first.reflectivity, 13);
  EXPECT_EQ(first.shot, 5);  // the ring
  EXPECT_EQ(cloud->points[1].x, 0.1F);
  EXPECT_EQ(cloud->points[1].y, 0.25F);
  EXPECT_EQ(cloud->points[1].reflectivity, 255);
  EXPECT_EQ(cloud->points[2].reflectivity, 0);
  EXPECT_TRUE(cloud->summary.has_ring);
}

TEST(PcdFile, ReadsBinaryWithPaddingDoublesAndSeveralCounts) {
  Bytes bytes = text_bytes(
      "VERSION .7\nFIELDS normal x _ y z reflectivity\nSIZE 4 8 1 8 8 1\nTYPE F F U F F U\nCOUNT 3 1 5 1 1 1\nWIDTH 2\n"
      "HEIGHT 1\nPOINTS 2\nDATA binary\n");
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) append(bytes, 9.0F);
    append(bytes, 1.0 + i);
    bytes.insert(bytes.end(), 5, 0xFF);
    append(bytes, 2.0);
    append(bytes, 3.0);
    append<std::uint8_t>(bytes, 200);
  }
  const Expected<PcdCloud> cloud = read_pcd(write_bytes("layout.pcd", bytes));
  ASSERT_TRUE(cloud) << cloud.error().message();
  ASSERT_EQ(cloud->points.size(), 2U);
  EXPECT_EQ(cloud->points[1].x, 2.0F);
  EXPECT_EQ(cloud->points[1].z, 3.0F);
  EXPECT_EQ(cloud->points[1].reflectivity, 200);
}

Bytes compressed_file(const Bytes& values, const std::string& points, std::uint32_t claimed_bytes) {
  Bytes packed(values.size() * 2 + 64);
  const unsigned size = lzf_compress(values.data(), static_cast<unsigned>(values.size()), packed.data(),
                                     static_cast<unsigned>(packed.size()));
  packed.resize(size);
  Bytes bytes = text_bytes(header("x y z intensity", "4 4 4 4", "F F F F", points, "binary_compressed"));
  append<std::uint32_t>(bytes, size);
  append<std::uint32_t>(bytes, claimed_bytes);
  return join({bytes, packed});
}

TEST(PcdFile, ReadsCompressedColumns) {
  Bytes values;
  for (int field = 0; field < 4; ++field) {
    for (int i = 0; i < 1000; ++i) append(values, static_cast<float>(field * 10 + i % 7 + 1));
  }
  const Expected<PcdCloud> cloud = read_pcd(write_bytes("packed.pcd", compressed_file(values, "1000", 16000)));
  ASSERT_TRUE(cloud) << cloud.error().message();
  ASSERT_EQ(cloud->points.size(), 1000U);
  EXPECT_EQ(cloud->points[8].x, 2.0F);
  EXPECT_EQ(cloud->points[8].y, 12.0F);
  EXPECT_EQ(cloud->points[8].z, 22.0F);
  EXPECT_EQ(cloud->points[8].reflectivity, 32);
}

TEST(PcdFile, RefusesDamagedCompression) {
  Bytes values(16000, 1);
  EXPECT_THAT(error_of(write_bytes("claim.pcd", compressed_file(values, "1000", 16001))), HasSubstr("16001 bytes"));
  Bytes cut = compressed_file(values, "1000", 16000);
  cut.resize(cut.size() - 5);
  EXPECT_THAT(error_of(write_bytes("cut_packed.pcd", cut)), HasSubstr("holds 0"));
  Bytes bomb = text_bytes(header("x y z intensity", "4 4 4 4", "F F F F", "268435455", "binary_compressed"));
  append<std::uint32_t>(bomb, 4);
  append<std::uint32_t>(bomb, 4294967280U);
  bomb.insert(bomb.end(), 4, 0xFF);
  EXPECT_THAT(error_of(write_bytes("bomb.pcd", bomb)), HasSubstr("damaged"));
  Bytes nothing = text_bytes(header("x y z", "4 4 4", "F F F", "1", "binary_compressed"));
  append<std::uint32_t>(nothing, 0);
  append<std::uint32_t>(nothing, 12);
  EXPECT_THAT(error_of(write_bytes("nothing.pcd", nothing)), HasSubstr("its compressed part is damaged"));
}

TEST(PcdFile, LeavesOutAndCountsWhatIsNoReturn) {
  const std::string path = write_text("holes.pcd", header("x y z", "4 4 4", "F F F", "6", "ascii") +
                                                       "nan nan nan\n0 0 0\n1 2 3\n0 0 1\n1 inf 1\n1e300 0 0\n");
  const Expected<PcdCloud> cloud = read_pcd(path);
  ASSERT_TRUE(cloud) << cloud.error().message();
  EXPECT_EQ(cloud->summary.points, 2U);
  EXPECT_EQ(cloud->summary.not_finite, 3U);
  EXPECT_EQ(cloud->summary.at_origin, 1U);
  EXPECT_FALSE(cloud->summary.has_reflectivity);
}

TEST(PcdFile, TellsWhereIntensitiesAreOfAnotherScale) {
  const auto complaint = [](const std::string& type, const std::string& low, const std::string& high) {
    const std::string path =
        write_text("scale.pcd", header("x y z intensity", "4 4 4 4", "F F F " + type, "3", "ascii") +
                                    "1 2 3 0\n1 2 3 " + low + "\n1 2 4 " + high + "\n");
    const Expected<PcdCloud> cloud = read_pcd(path);
    return cloud ? cloud->summary.intensity.complaint() : cloud.error().message();
  };
  EXPECT_THAT(complaint("F", "0.31", "0.99"), HasSubstr("at most 0.99, and of their fractions nothing is left"));
  EXPECT_THAT(complaint("F", "0.31", "1"), HasSubstr("scale them to 0..255"));
  EXPECT_THAT(complaint("U", "200", "65535"), HasSubstr("reach 65535, and all above 255 count as 255"));
  EXPECT_EQ(complaint("F", "0", "1"), "") << "very dark";
  EXPECT_EQ(complaint("F", "0.31", "255"), "");
  // Written as most programs write it, which is read another way.
  std::vector<std::uint8_t> bytes;
  const std::string head = header("x y z intensity tag", "4 4 4 4 1", "F F F F U", "1", "binary");
  bytes.assign(head.begin(), head.end());
  for (const float value : {1.0F, 2.0F, 3.0F, 0.5F}) append(bytes, value);
  append<std::uint8_t>(bytes, 0);
  const Expected<PcdCloud> usual = read_pcd(write_bytes("usual.pcd", bytes));
  ASSERT_TRUE(usual) << usual.error().message();
  EXPECT_EQ(usual->summary.intensity.largest, 0.5);
  EXPECT_TRUE(usual->summary.intensity.has_fractions);
}

TEST(PcdFile, AcceptsAWidthOfZeroAndSaysSo) {
  const std::string text = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 0\nHEIGHT 0\nPOINTS 1\nDATA ascii\n1 2 3\n";
  const Expected<PcdCloud> cloud = read_pcd(write_text("width.pcd", text));
  ASSERT_TRUE(cloud) << cloud.error().message();
  EXPECT_EQ(cloud->points.size(), 1U);
  EXPECT_TRUE(cloud->summary.size_missing);
}

TEST(PcdFile, SaysThatItsViewpointIsAnotherPose) {
  const auto is_moved = [](const std::string& viewpoint) {
    const std::string text = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nVIEWPOINT " + viewpoint +
                             "\nPOINTS 1\nDATA ascii\n1 2 3\n";
    const Expected<PcdCloud> cloud = read_pcd(write_text("viewpoint.pcd", text));
    EXPECT_TRUE(cloud) << cloud.error().message();
    EXPECT_EQ(cloud->points[0].x, 1.0F) << "it is not applied";
    return cloud->summary.moved;
  };
  EXPECT_FALSE(is_moved("0 0 0 1 0 0 0"));
  EXPECT_FALSE(is_moved("0.0 -0 0 -1 0 0 0"));
  EXPECT_FALSE(is_moved("0 0 0"));
  EXPECT_TRUE(is_moved("0 0 0.1 1 0 0 0"));
  EXPECT_TRUE(is_moved("0 0 0 0.7071 0 0.7071 0"));
}

TEST(PcdFile, FewerPointsThanPromisedIsAnError) {
  EXPECT_THAT(error_of(write_text("few.pcd", header("x y z", "4 4 4", "F F F", "3", "ascii") + "1 2 3\n1 2 3\n")),
              HasSubstr("promises 3 points, but holds 2"));
  Bytes binary = text_bytes(header("x y z", "4 4 4", "F F F", "3", "binary"));
  binary.insert(binary.end(), 35, 1);
  EXPECT_THAT(error_of(write_bytes("few_binary.pcd", binary)), HasSubstr("promises 3 points, but holds 2"));
}

TEST(PcdFile, HostilePointCountsCostNoMemory) {
  const Bytes bytes = text_bytes(header("x y z", "4 4 4", "F F F", "1000000000000", "binary"));
  EXPECT_THAT(error_of(write_bytes("huge.pcd", bytes)), HasSubstr("holds 0"));
  EXPECT_THAT(error_of(write_text("huger.pcd", header("x y z", "4 4 4", "F F F", "99999999999999999", "binary"))),
              HasSubstr("no possible number"));
}

TEST(PcdFile, NamesTheLineOfAMistake) {
  EXPECT_THAT(error_of(write_text("word.pcd", header("x y z", "4 4 4", "F F F", "2", "ascii") + "1 2 3\n1 two 3\n")),
              HasSubstr("word.pcd:12: has no 3 numbers"));
  EXPECT_THAT(error_of(write_text("fields.pcd", header("x y", "4 4", "F F", "1", "ascii"))),
              HasSubstr("fields.pcd:3: FIELDS has no z; a cloud needs"));
  EXPECT_THAT(error_of(write_text("type.pcd", header("x y z", "4 4 4", "F U F", "1", "ascii"))),
              HasSubstr("type.pcd:5: the field y is of TYPE U, not F; write x, y and z as floats"));
  EXPECT_THAT(error_of(write_text("size.pcd", header("x y z", "4 4", "F F F", "1", "ascii"))), HasSubstr("differ"));
  EXPECT_THAT(error_of(write_text("size3.pcd", header("x y z", "4 4 3", "F F F", "1", "ascii"))), HasSubstr("SIZE 3"));
  EXPECT_THAT(error_of(write_text("twice.pcd", header("x x y z", "4 4 4 4", "F F F F", "1", "ascii"))),
              HasSubstr("two fields"));
  EXPECT_THAT(error_of(write_text("words.pcd", header("x y z", "4 4 four", "F F F", "1", "ascii"))),
              HasSubstr("words.pcd:4: SIZE is not a list of numbers; correct the header, or save the cloud anew"));
  EXPECT_THAT(error_of(write_text("data.pcd", header("x y z", "4 4 4", "F F F", "1", "zip"))),
              HasSubstr("DATA is not"));
  EXPECT_THAT(error_of(write_text("wh.pcd",
                                  "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 2\nPOINTS 5\n"
                                  "DATA ascii\n")),
              HasSubstr("wh.pcd:7: WIDTH times HEIGHT is not POINTS"));
}

TEST(PcdFile, NamesFilesThatAreNoClouds) {
  EXPECT_THAT(error_of(fresh_path("missing.pcd")), HasSubstr("no such file"));
  EXPECT_THAT(error_of(write_text("empty.pcd", "")), HasSubstr("is empty"));
  EXPECT_THAT(error_of(write_text("noise.pcd", "some text\n")), HasSubstr("no PCD file"));
  EXPECT_THAT(error_of(write_text("comment.pcd", "# only a remark\n")), HasSubstr("no DATA line"));
  EXPECT_THAT(error_of(testing::TempDir()), HasSubstr("is a folder"));
  const std::string pipe = fresh_path("pipe.pcd");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(error_of(pipe), HasSubstr("is no regular file; copy it to a file first")) << "nobody writes to it";
}

}  // namespace
}  // namespace rigcal
