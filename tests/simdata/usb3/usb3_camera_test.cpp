#include "simdata/usb3/usb3_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/base/network_order.h"
#include "core/base/random.h"
#include "simdata/usb3/stream_packet.h"

namespace rigcal::sim::usb3 {
namespace {

using gige::Status;
using testing::HasSubstr;
using testing::Not;

constexpr std::int64_t ms = 1'000'000;

/// A host that talks with the camera, and a clock.
class Desk {
 public:
  Desk() : camera_(options(), now) {}
  static VirtualCameraOptions options() {
    VirtualCameraOptions options;
    options.identity.manufacturer = "Hikrobot";
    options.identity.model = "MV-CA013-21UC";
    options.identity.serial = "00F12345678";
    options.pixel_formats = {"Mono8", "BayerRG8"};
    options.width = 640;
    options.height = 480;
    return options;
  }
  /// Status and data of an answer.
  struct Answer {
    std::uint16_t status = 0xFFFF;
    std::uint16_t command = 0;
    std::uint16_t id = 0;
    std::vector<std::uint8_t> data;
  };
  Answer send(const std::vector<std::uint8_t>& packet) {
    const std::vector<std::uint8_t> bytes = camera_.receive(now, packet);
    ByteReader reader(bytes);
    Answer answer;
    if (bytes.empty()) return answer;
    EXPECT_EQ(reader.read<std::uint32_t>(), 0x43563355U);
    answer.status = reader.read<std::uint16_t>();
    answer.command = reader.read<std::uint16_t>();
    const auto length = reader.read<std::uint16_t>();
    answer.id = reader.read<std::uint16_t>();
    const ByteView data = reader.take(length);
    EXPECT_TRUE(reader.ok());
    EXPECT_EQ(reader.left(), 0U);
    answer.data.assign(data.begin(), data.end());
    return answer;
  }
  std::vector<std::uint8_t> read(std::uint64_t address, std::uint16_t count) {
    const Answer answer = send(encode_read(++id_, address, count));
    EXPECT_EQ(answer.status, 0U) << std::hex << address;
    EXPECT_EQ(answer.id, id_);
    return answer.data;
  }
  template <class T>
  T value(std::uint64_t address) {
    const auto bytes = read(address, sizeof(T));
    return ByteReader(bytes).read<T>();
  }
  std::string text(std::uint64_t address, std::uint16_t count) {
    const auto bytes = read(address, count);
    return {bytes.begin(), bytes.end()};
  }
  std::uint16_t write_table(std::uint64_t address, std::uint32_t value) {
    std::vector<std::uint8_t> bytes;
    ByteWriter(bytes).write(value);
    return send(encode_write(++id_, address, bytes)).status;
  }
  std::uint16_t write(Feature feature, std::uint32_t value) {
    std::vector<std::uint8_t> bytes;
    ByteWriter writer(bytes);
    write_network(writer, value);
    return send(encode_write(++id_, address_of(feature), bytes)).status;
  }
  std::vector<FrameOrder> frames_after(std::int64_t time_ns) {
    now += time_ns;
    std::vector<FrameOrder> frames;
    camera_.tick(now, frames);
    return frames;
  }
  Usb3Camera& camera() { return camera_; }

  std::int64_t now = 1000 * ms;

 private:
  Usb3Camera camera_;
  std::uint16_t id_ = 0;
};

TEST(Usb3Camera, SaysWhoItIsAndWhereItsTablesAre) {
  Desk desk;
  EXPECT_THAT(desk.text(usb3_names::kManufacturer, 64), testing::StartsWith(std::string("Hikrobot\0", 9)));
  EXPECT_THAT(desk.text(usb3_names::kSerial, 64), testing::StartsWith("00F12345678"));
  EXPECT_EQ(desk.value<std::uint64_t>(table::kSecondAddress), table::kSecond);
  EXPECT_EQ(desk.value<std::uint64_t>(table::kStreamAddress), table::kStream);
  EXPECT_EQ(desk.value<std::uint64_t>(table::kPayloadBytes), 640U * 480U);
  EXPECT_EQ(desk.value<std::uint32_t>(table::kResponseTime), 1000U);
}

TEST(Usb3Camera, DescribesItselfAsACameraOnUsb) {
  Desk desk;
  ASSERT_EQ(desk.value<std::uint64_t>(table::kManifest), 1U);
  const auto address = desk.value<std::uint64_t>(table::kManifest + 16);
  const auto size = desk.value<std::uint64_t>(table::kManifest + 24);
  std::string xml;
  while (xml.size() < size)
    xml += desk.text(address + xml.size(), static_cast<std::uint16_t>(std::min<std::uint64_t>(777, size - xml.size())));
  EXPECT_TRUE(xml == describe_camera(Desk::options().pixel_formats, Transport::usb3));
  EXPECT_THAT(xml, HasSubstr("StandardNameSpace=\"U3V\""));
  EXPECT_THAT(xml, HasSubstr("<Address>0x00000144</Address>\n    <Length>64</Length>"));
  EXPECT_THAT(xml, Not(HasSubstr("Gev")));
  EXPECT_THAT(xml, Not(HasSubstr("ChunkModeActive\"")));
}

TEST(Usb3Camera, SendsFramesOnceTheStreamIsOpen) {
  Desk desk;
  EXPECT_EQ(desk.write(Feature::acquisition_start, 1), 0U);
  EXPECT_TRUE(desk.frames_after(100 * ms).empty());
  EXPECT_EQ(desk.write_table(table::kStreamControl, 1), 0U);
  const auto frames = desk.frames_after(100 * ms);
  ASSERT_GE(frames.size(), 2U);
  EXPECT_EQ(frames[1].number, frames[0].number + 1);
  EXPECT_GT(Usb3Camera::stamp_ns(frames[1]), Usb3Camera::stamp_ns(frames[0]) + 5 * ms);
  desk.camera().detach(desk.now);
  EXPECT_TRUE(desk.frames_after(100 * ms).empty());
}

TEST(Usb3Camera, ExposesForEachPulseOnItsLine) {
  Desk desk;
  ASSERT_EQ(desk.write(Feature::trigger_mode, 1), 0U);
  ASSERT_EQ(desk.write(Feature::trigger_source, 0), 0U);
  ASSERT_EQ(desk.write(Feature::acquisition_start, 1), 0U);
  ASSERT_EQ(desk.write_table(table::kStreamControl, 1), 0U);
  EXPECT_TRUE(desk.frames_after(200 * ms).empty());
  desk.camera().pulse({0, desk.now, desk.now + ms, 42});
  const auto frames = desk.frames_after(200 * ms);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].pulse, 42);
}

TEST(Usb3Camera, LeadsAndEndsAFrameAsTheStandardSays) {
  Desk desk;
  ASSERT_EQ(desk.write(Feature::acquisition_start, 1), 0U);
  ASSERT_EQ(desk.write_table(table::kStreamControl, 1), 0U);
  const FrameOrder frame = desk.frames_after(100 * ms).at(1);
  const auto leader = encode_leader(frame, 0x1122334455667788);
  ASSERT_EQ(leader.size(), kLeaderBytes);
  EXPECT_EQ(std::string(leader.begin(), leader.begin() + 4), "U3VL");
  ByteReader reader(ByteView(leader).subspan(8));
  EXPECT_EQ(reader.read<std::uint64_t>(), frame.number);
  EXPECT_EQ(reader.read<std::uint32_t>(), 0x0001'0000U);
  EXPECT_EQ(reader.read<std::uint64_t>(), 0x1122334455667788U);
  EXPECT_EQ(reader.read<std::uint32_t>(), 0x0108'0001U);  // Mono8
  EXPECT_EQ(reader.read<std::uint32_t>(), 640U);
  EXPECT_EQ(reader.read<std::uint32_t>(), 480U);
  const auto trailer = encode_trailer(frame);
  ASSERT_EQ(trailer.size(), kTrailerBytes);
  EXPECT_EQ(std::string(trailer.begin(), trailer.begin() + 4), "U3VT");
  EXPECT_EQ(ByteReader(ByteView(trailer).subspan(20)).read<std::uint64_t>(), 640U * 480U);
}

TEST(Usb3Camera, RefusesWhatIsNotThere) {
  Desk desk;
  const auto status_of = [&desk](const std::vector<std::uint8_t>& packet) { return desk.send(packet).status; };
  const std::vector<std::uint8_t> word(4);
  EXPECT_EQ(status_of(encode_read(1, 0x5000, 4)), static_cast<std::uint16_t>(Status::invalid_address));
  EXPECT_EQ(status_of(encode_read(2, table::kEnd - 2, 4)), static_cast<std::uint16_t>(Status::invalid_address));
  EXPECT_EQ(status_of(encode_read(3, UINT64_MAX - 2, 8)), static_cast<std::uint16_t>(Status::invalid_address));
  EXPECT_EQ(status_of(encode_read(4, 0, 2000)), static_cast<std::uint16_t>(Status::invalid_parameter));
  EXPECT_EQ(status_of(encode_write(5, table::kSecondAddress, word)),
            static_cast<std::uint16_t>(Status::write_protected));
  EXPECT_EQ(desk.write(Feature::chunk_mode, 1), static_cast<std::uint16_t>(Status::access_denied));
  EXPECT_EQ(desk.write(Feature::width, 100'000), static_cast<std::uint16_t>(Status::invalid_parameter));
  std::vector<std::uint8_t> unknown = encode_read(6, 0, 4);
  unknown[6] = 0x77;
  EXPECT_EQ(status_of(unknown), static_cast<std::uint16_t>(Status::not_implemented));
  EXPECT_TRUE(desk.camera().receive(desk.now, {}).empty());
}

TEST(Usb3Camera, AnswersAsEverAfterAnyBytes) {
  Desk desk;
  Random random(17);
  const std::vector<std::uint8_t> packets[] = {
      encode_read(1, address_of(Feature::width), 64),
      encode_write(2, table::kStreamControl, std::vector<std::uint8_t>(4, 1)),
      encode_write(3, address_of(Feature::width), std::vector<std::uint8_t>(8))};
  std::vector<FrameOrder> frames;
  for (int i = 0; i < 20'000; ++i) {
    std::vector<std::uint8_t> packet = packets[random.below(3)];
    for (std::uint64_t change = random.below(4); change > 0; --change)
      packet[4 + random.below(packet.size() - 4)] = static_cast<std::uint8_t>(random.next_u64());
    packet.resize(random.below(packet.size() + 1));
    static_cast<void>(desk.camera().receive(desk.now, packet));
    if (i % 100 != 0) continue;
    frames = desk.frames_after(ms);
    ASSERT_THAT(desk.text(usb3_names::kSerial, 64), testing::StartsWith("00F12345678")) << i;
    ASSERT_EQ(desk.value<std::uint64_t>(table::kStreamAddress), table::kStream) << i;
  }
}

}  // namespace
}  // namespace rigcal::sim::usb3
