#include "core/io/las_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/core/io/dump_bytes.h"

namespace rigcal {
namespace {

/// A LAS 1.4 file read by the offsets of ASPRS's specification (R15, tables 3, 7 and 8), not by what the writer thinks.
class LasBytes {
 public:
  explicit LasBytes(Bytes bytes) : bytes_(std::move(bytes)) {}
  template <class T>
  [[nodiscard]] T at(std::size_t offset) const {
    T value{};
    EXPECT_LE(offset + sizeof(T), bytes_.size());
    if (offset + sizeof(T) <= bytes_.size()) std::memcpy(&value, bytes_.data() + offset, sizeof(T));
    return value;
  }
  [[nodiscard]] std::string text(std::size_t offset, std::size_t size) const {
    return {bytes_.begin() + static_cast<std::ptrdiff_t>(offset),
            bytes_.begin() + static_cast<std::ptrdiff_t>(offset + size)};
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

 private:
  Bytes bytes_;
};

// 14 November 2023, 22:13:20 UTC: day 318.
constexpr std::int64_t stamp = 1'700'000'000'000'000'000;

std::vector<Point> some_points() {
  return {{1.5F, -2.25F, 0.125F, 255, 0x10, 0}, {-100.0F, 7.0F, 3.0F, 1, 2, 10}, {4.0F, 0.0001F, -9.5F, 0, 0, 20}};
}

LasBytes written(const std::string& name, const LasWriter::Options& options, const std::vector<Point>& points) {
  const std::string path = fresh_path(name);
  Expected<LasWriter> writer = LasWriter::create(path, options);
  EXPECT_TRUE(writer.has_value());
  writer->write(std::span(points).first(points.size() / 2), stamp, 10'000.0);
  writer->write(std::span(points).subspan(points.size() / 2), stamp, 10'000.0);
  EXPECT_TRUE(writer->finish().has_value());
  return LasBytes(read_bytes(path));
}

TEST(LasFile, HasEveryFieldOfTheHeaderWhereTheSpecificationWantsIt) {
  const LasBytes las = written("a.las", {7, true}, some_points());
  ASSERT_EQ(las.size(), 375U + 3U * 28U);
  EXPECT_EQ(las.text(0, 4), "LASF");
  EXPECT_EQ(las.at<std::uint16_t>(4), 7) << "file source id";
  EXPECT_EQ(las.at<std::uint16_t>(6), 1) << "global encoding: adjusted standard GPS time, no WKT";
  EXPECT_EQ(las.text(8, 16), std::string(16, '\0'));
  EXPECT_EQ(las.at<std::uint8_t>(24), 1);
  EXPECT_EQ(las.at<std::uint8_t>(25), 4);
  EXPECT_EQ(las.text(26, 6), std::string("OTHER\0", 6));
  EXPECT_EQ(las.text(58, 7), "rigcal ");
  EXPECT_EQ(las.at<std::uint16_t>(90), 318) << "day of the year";
  EXPECT_EQ(las.at<std::uint16_t>(92), 2023);
  EXPECT_EQ(las.at<std::uint16_t>(94), 375) << "header size";
  EXPECT_EQ(las.at<std::uint32_t>(96), 375U) << "offset to the points";
  EXPECT_EQ(las.at<std::uint32_t>(100), 0U) << "variable length records";
  EXPECT_EQ(las.at<std::uint8_t>(104), 1) << "point format";
  EXPECT_EQ(las.at<std::uint16_t>(105), 28);
  EXPECT_EQ(las.at<std::uint32_t>(107), 3U) << "legacy count";
  EXPECT_EQ(las.at<std::uint32_t>(111), 3U) << "legacy count of first returns";
  for (std::size_t i = 1; i < 5; ++i) EXPECT_EQ(las.at<std::uint32_t>(111 + 4 * i), 0U);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(las.at<double>(131 + 8 * axis), 1e-4) << "scale";
    EXPECT_EQ(las.at<double>(155 + 8 * axis), 0.0) << "offset";
  }
  const double bounds[] = {4.0, -100.0, 7.0, -2.25, 3.0, -9.5};  // max x, min x, max y ...
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(las.at<double>(179 + 8 * i), bounds[i], 1e-9) << i;
  EXPECT_EQ(las.at<std::uint64_t>(227), 0U) << "waveforms";
  EXPECT_EQ(las.at<std::uint64_t>(235), 0U) << "extended records";
  EXPECT_EQ(las.at<std::uint32_t>(243), 0U);
  EXPECT_EQ(las.at<std::uint64_t>(247), 3U) << "points";
  EXPECT_EQ(las.at<std::uint64_t>(255), 3U) << "first returns";
  for (std::size_t i = 1; i < 15; ++i) EXPECT_EQ(las.at<std::uint64_t>(255 + 8 * i), 0U);
}

TEST(LasFile, HoldsThePoints) {
  const std::vector<Point> points = some_points();
  const LasBytes las = written("b.las", {7, true}, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t at = 375 + 28 * i;
    EXPECT_NEAR(las.at<std::int32_t>(at) * 1e-4, static_cast<double>(points[i].x), 5.1e-5);
    EXPECT_NEAR(las.at<std::int32_t>(at + 4) * 1e-4, static_cast<double>(points[i].y), 5.1e-5);
    EXPECT_NEAR(las.at<std::int32_t>(at + 8) * 1e-4, static_cast<double>(points[i].z), 5.1e-5);
    EXPECT_EQ(las.at<std::uint16_t>(at + 12), points[i].reflectivity * 256);
    EXPECT_EQ(las.at<std::uint8_t>(at + 14), 0x09) << "return 1 of 1";
    EXPECT_EQ(las.at<std::uint8_t>(at + 15), 0) << "never classified";
    EXPECT_EQ(las.at<std::uint8_t>(at + 16), 0) << "scan angle";
    EXPECT_EQ(las.at<std::uint8_t>(at + 17), points[i].tag) << "user data";
    EXPECT_EQ(las.at<std::uint16_t>(at + 18), 7) << "point source";
    // GPS time is UTC + 18 s, from 6 January 1980 (315964800 s after 1970).
    const double gps = 1.7e9 + 1e-5 * points[i].shot + 18.0 - 315964800.0 - 1e9;
    EXPECT_NEAR(las.at<double>(at + 20), gps, 1e-6);
  }
}

TEST(LasFile, WithoutTimesIsOfPointFormatZero) {
  const LasBytes las = written("c.las", {2, false}, some_points());
  ASSERT_EQ(las.size(), 375U + 3U * 20U);
  EXPECT_EQ(las.at<std::uint16_t>(6), 0);
  EXPECT_EQ(las.at<std::uint16_t>(90), 0);
  EXPECT_EQ(las.at<std::uint8_t>(104), 0);
  EXPECT_EQ(las.at<std::uint16_t>(105), 20);
  EXPECT_EQ(las.at<std::int32_t>(375 + 2 * 20), 40000);
}

TEST(LasFile, LeavesOutWhatItsIntegersCannotHold) {
  const std::string path = fresh_path("d.las");
  Expected<LasWriter> writer = LasWriter::create(path, {1, true});
  ASSERT_TRUE(writer.has_value());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Point> points{{3e5F, 0, 0, 0, 0, 0}, {nan, 0, 0, 0, 0, 0}, {2e5F, 1, 1, 0, 0, 0}};
  writer->write(points, stamp, 0.0);
  EXPECT_EQ(writer->points(), 1U);
  EXPECT_EQ(writer->left_out(), 2U);
  EXPECT_TRUE(writer->finish().has_value());
  EXPECT_EQ(LasBytes(read_bytes(path)).at<std::int32_t>(375), 2'000'000'000);
}

TEST(LasFile, EmptyIsAWholeFile) {
  const LasBytes las = written("e.las", {1, true}, {});
  EXPECT_EQ(las.size(), 375U);
  EXPECT_EQ(las.at<std::uint64_t>(247), 0U);
  EXPECT_EQ(las.at<double>(179), 0.0);
}

}  // namespace
}  // namespace rigcal
