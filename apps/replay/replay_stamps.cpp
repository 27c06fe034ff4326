#include "apps/replay/replay_stamps.h"

#include <algorithm>
#include <cmath>

#include "core/base/seconds.h"
#include "simdata/live/live_stamp.h"

namespace rigcal {
namespace {

constexpr std::int64_t last_gps_ns = 8'990'000'000 * ns_per_second;  // The year on the wire ends with 2255.
constexpr std::int64_t first_gps_ns = 946'684'800 * ns_per_second;   // It begins with 2000.

constexpr float farthest_m = 1e6F;  // No packet holds more in both coordinates.

livox::DataType in_other_coordinates(livox::DataType type) {
  switch (type) {
    case livox::DataType::cartesian:
      return livox::DataType::spherical;
    case livox::DataType::spherical:
      return livox::DataType::cartesian;
    case livox::DataType::cartesian_tagged:
      return livox::DataType::spherical_tagged;
    case livox::DataType::spherical_tagged:
      return livox::DataType::cartesian_tagged;
    case livox::DataType::dual_cartesian:
      return livox::DataType::dual_spherical;
    case livox::DataType::dual_spherical:
      return livox::DataType::dual_cartesian;
    case livox::DataType::triple_cartesian:
      return livox::DataType::triple_spherical;
    case livox::DataType::triple_spherical:
      return livox::DataType::triple_cartesian;
    case livox::DataType::imu:
      break;
  }
  return type;
}

}  // namespace

void ReplayStamps::rewrite(const ReplayPace& pace, std::int64_t received_ns, std::vector<std::uint8_t>& packet) {
  const auto parsed = livox::parse_sample_packet(packet);
  if (!parsed) return;
  const livox::SampleHeader header = parsed->header;
  const bool by_pulse = header.timestamp_type == livox::TimestampType::pps_only;
  const std::int64_t recorded_ns = by_pulse ? pulse_.add(header.device_stamp_ns, received_ns) : header.device_stamp_ns;
  if (!first_ns_) first_ns_ = recorded_ns;
  std::int64_t stamp_ns = header.device_stamp_ns;
  if (pace.speed != 1.0 || pace.earlier_ns != 0) {
    // Stamps are never negative, so that their difference fits; with earlier passes only a double holds it.
    const double since_first =
        (static_cast<double>(recorded_ns - *first_ns_) + static_cast<double>(pace.earlier_ns)) / pace.speed;
    const double limit = static_cast<double>(last_gps_ns);
    stamp_ns = *first_ns_ + std::llround(std::clamp(since_first, -limit, limit - static_cast<double>(*first_ns_)));
    if (by_pulse) stamp_ns = ((stamp_ns % ns_per_second) + ns_per_second) % ns_per_second;
  }
  stamp_ns = std::max<std::int64_t>(0, stamp_ns);
  if (header.timestamp_type == livox::TimestampType::since_start) {
    if (restart_stamp_ns_) started_ns_ = stamp_ns - *restart_stamp_ns_;
    restart_stamp_ns_.reset();
    stamp_ns = std::max<std::int64_t>(0, stamp_ns - started_ns_);
  }
  if (header.timestamp_type == livox::TimestampType::gps) stamp_ns = std::clamp(stamp_ns, first_gps_ns, last_gps_ns);
  if (stamp_ns != header.device_stamp_ns)
    livox::overwrite_stamp(header.status, header.timestamp_type, stamp_ns, packet);
  if (header.data_type == livox::DataType::imu) sim::speed_up_gyro(pace.speed, packet);
}

void change_coordinates(bool spherical, std::vector<std::uint8_t>& packet) {
  const auto parsed = livox::parse_sample_packet(packet);
  if (!parsed || parsed->header.data_type == livox::DataType::imu) return;
  if (livox::record_layout(parsed->header.data_type).spherical == spherical) return;
  livox::SampleHeader header = parsed->header;
  header.data_type = in_other_coordinates(header.data_type);
  std::vector<Point> points;
  livox::decode_points(*parsed, points);
  std::erase_if(points, [](const Point& point) {
    return !(point.x * point.x + point.y * point.y + point.z * point.z < farthest_m * farthest_m);
  });
  livox::encode_points(header, points, packet);
}

}  // namespace rigcal
