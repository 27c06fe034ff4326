// Bags as ROS's own library writes them, read back message by message; built where that library is there.
#include <gtest/gtest.h>
#include <rosbag/bag.h>

#include "core/io/bag_reader.h"
#include "tests/core/io/dump_bytes.h"

namespace rigcal {
namespace {

/// Bytes that pass for a message of any type.
struct RawMessage {
  std::string type;
  std::vector<std::uint8_t> bytes;
};

}  // namespace
}  // namespace rigcal

namespace ros {
namespace message_traits {

template <>
struct IsMessage<rigcal::RawMessage> : TrueType {};
template <>
struct IsMessage<const rigcal::RawMessage> : TrueType {};
template <>
struct MD5Sum<rigcal::RawMessage> {
  static const char* value(const rigcal::RawMessage&) { return "992ce8a1687cec8c8bd883ec73ca41d1"; }
  static const char* value() { return "*"; }
};
template <>
struct DataType<rigcal::RawMessage> {
  static const char* value(const rigcal::RawMessage& message) { return message.type.c_str(); }
  static const char* value() { return "*"; }
};
template <>
struct Definition<rigcal::RawMessage> {
  static const char* value(const rigcal::RawMessage&) { return "string data\n"; }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<rigcal::RawMessage> {
  template <class Stream>
  static void write(Stream& stream, const rigcal::RawMessage& message) {
    std::memcpy(stream.advance(static_cast<std::uint32_t>(message.bytes.size())), message.bytes.data(),
                message.bytes.size());
  }
  static std::uint32_t serializedLength(const rigcal::RawMessage& message) {
    return static_cast<std::uint32_t>(message.bytes.size());
  }
};

}  // namespace serialization
}  // namespace ros

namespace rigcal {
namespace {

TEST(RosbagLibrary, WritesBagsThatReadBack) {
  for (const auto compression :
       {rosbag::compression::Uncompressed, rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    const std::string path = fresh_path("library.bag");
    {
      rosbag::Bag bag(path, rosbag::bagmode::Write);
      bag.setCompression(compression);
      bag.setChunkThreshold(2000);
      for (std::uint32_t i = 0; i < 200; ++i) {
        const RawMessage message{i % 2 == 0 ? "test_msgs/Even" : "test_msgs/Odd",
                                 std::vector<std::uint8_t>(50 + i, static_cast<std::uint8_t>(i))};
        bag.write(i % 2 == 0 ? "/even" : "/odd", ros::Time(1000 + i, 7), message);
      }
    }
    Expected<BagReader> reader = BagReader::open(path);
    ASSERT_TRUE(reader.has_value()) << reader.error().message();
    EXPECT_TRUE(reader->indexed());
    BagMessage message;
    for (std::uint32_t i = 0; i < 200; ++i) {
      const Expected<bool> more = reader->next(message);
      ASSERT_TRUE(more.has_value() && *more) << i;
      EXPECT_EQ(message.connection->topic, i % 2 == 0 ? "/even" : "/odd");
      EXPECT_EQ(message.connection->type, i % 2 == 0 ? "test_msgs/Even" : "test_msgs/Odd");
      EXPECT_EQ(message.connection->md5, "992ce8a1687cec8c8bd883ec73ca41d1");
      EXPECT_EQ(message.stamp_ns, (1000 + std::int64_t{i}) * 1'000'000'000 + 7);
      EXPECT_EQ(message.bytes.size(), 50 + i);
      EXPECT_EQ(message.bytes[20], static_cast<std::uint8_t>(i));
    }
    EXPECT_FALSE(*reader->next(message));
    EXPECT_EQ(reader->truncation(), "");
  }
}

}  // namespace
}  // namespace rigcal
