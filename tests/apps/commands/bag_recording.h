#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/io/pcap_reader.h"
#include "drivers/livox_codec/sample_packet.h"
#include "tests/support/bag_bytes.h"
#include "tests/support/ros_bytes.h"

namespace rigcal {

/// Turns a dump of sample packets into a bag as Livox's driver records it: clouds of 100 ms of each device, sent when
/// they are complete, and each inertial reading. Addresses that end in `plain` send PointCloud2 with a time field "t",
/// the others CustomMsg. Topics: /livox/lidar_<last number of the address>, /livox/imu_<the same>.
inline BagBytes bag_of_dump(const std::string& dump, std::uint8_t plain, const std::string& compression = "none") {
  constexpr std::int64_t cloud_ns = 100'000'000;
  constexpr std::int64_t way_ns = 300'000;  // from the driver to the recorder
  struct Device {
    std::vector<RosPoint> points;
    std::int64_t start_ns = 0;
    std::uint32_t seq = 0;
    std::uint32_t imu_seq = 0;
  };
  BagBytes bag;
  bag.compression = compression;
  std::map<std::uint8_t, Device> devices;
  auto reader = PcapReader::open(dump);
  const auto send = [&](std::uint8_t number, Device& device, std::int64_t now_ns) {
    const std::string topic = "/livox/lidar_" + std::to_string(number);
    if (number != plain) {
      bag.add(topic, livox_type, livox_md5, now_ns, livox_message(device.seq++, device.start_ns, device.points));
    } else {
      RosBytes data;
      ByteWriter out(data);
      for (const auto& [point, offset_ns] : device.points) {
        out.write(point.x);
        out.write(point.y);
        out.write(point.z);
        out.write(static_cast<float>(point.reflectivity));
        out.write(point.tag);
        out.write(offset_ns);
      }
      const auto width = static_cast<std::uint32_t>(device.points.size());
      bag.add(topic, cloud_type, cloud_md5, now_ns,
              cloud_message(device.seq++, device.start_ns,
                            {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"intensity", 12, 7}, {"tag", 16, 2}, {"t", 17, 6}},
                            {1, width, 21, 21 * width, false}, data));
    }
    device.points.clear();
    bag.flush();
  };
  std::vector<Point> points;
  for (Datagram datagram; *reader->next(datagram);) {
    const auto packet = livox::parse_sample_packet(datagram.bytes);
    if (!packet) continue;
    const std::uint8_t number = datagram.from.ip[3];
    Device& device = devices[number];
    const std::int64_t sent_ns = packet->header.device_stamp_ns;
    if (packet->header.data_type == livox::DataType::imu) {
      const auto reading = livox::decode_imu(*packet);
      const auto& gyro = reading->gyro_rad_s;
      const auto& a = reading->acceleration_g;
      bag.add("/livox/imu_" + std::to_string(number), imu_type, imu_md5, datagram.stamp_ns + way_ns,
              imu_message(device.imu_seq++, sent_ns, Vector3d(gyro[0], gyro[1], gyro[2]), Vector3d(a[0], a[1], a[2])));
      continue;
    }
    if (!device.points.empty() && sent_ns - device.start_ns >= cloud_ns) {
      send(number, device, datagram.stamp_ns + way_ns);
    }
    if (device.points.empty()) device.start_ns = sent_ns;
    livox::decode_points(*packet, points);
    const double interval_ns = number == plain ? 10'000.0 : 1e9 / 240'000.0;
    for (const Point& point : points) {
      device.points.push_back({point, static_cast<std::uint32_t>(static_cast<double>(sent_ns - device.start_ns) +
                                                                 point.shot * interval_ns)});
    }
  }
  return bag;
}

}  // namespace rigcal
