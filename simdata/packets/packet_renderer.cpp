#include "simdata/packets/packet_renderer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/seconds.h"

namespace rigcal::sim {
namespace {

enum Stream : std::uint64_t { imu_error_stream = 500, device_stream = 1ULL << 40U };

// Numbers k >= 0 of a series with `step_ns` in device time whose true time falls into a block.
struct Series {
  std::int64_t first = 0;
  std::int64_t end = 0;
};

Series series_in(const DeviceClock& clock, double start_s, double end_s, std::int64_t step_ns) {
  const auto index = [&](double time_s) {
    const std::int64_t device = clock.stamp_ns(time_s) - clock.stamp_at_zero_ns;
    return std::max<std::int64_t>(0, (device + step_ns - 1) / step_ns);
  };
  return {index(start_s), index(end_s)};
}

// Poses within a packet: the turn is below a thousandth of a radian there, so first order is exact to 1e-7 rad.
struct PacketMotion {
  SE3 start;
  Vector3d turn = Vector3d::Zero();
  Vector3d shift = Vector3d::Zero();
  bool moves = false;

  PacketMotion(const SE3& first, const SE3& last) : start(first), shift(last.t - first.t) {
    turn = log_so3(first.R.transpose() * last.R);
    moves = turn.norm() > 1e-9 || shift.norm() > 1e-9;
  }
  [[nodiscard]] SE3 at(double share) const {
    return {start.R * (Matrix3d::Identity() + skew(share * turn)), start.t + share * shift};
  }
};

}  // namespace

ImuErrors draw_imu_errors(std::uint64_t seed, int sensor) {
  Random random(seed, imu_error_stream + static_cast<std::uint64_t>(sensor));
  return ImuErrors::draw(random);
}

PacketRenderer::PacketRenderer(const RayCaster& caster, const std::vector<Material>& materials, const SimulatedRig& rig,
                               const SimulatedLidar& lidar, const SimDevice& device, const PacketPath& path,
                               std::uint64_t seed)
    : caster_(caster),
      rig_(rig),
      lidar_(lidar),
      device_(device),
      path_(path),
      seed_(seed),
      meter_(caster, materials, lidar.noise, livox::record_layout(device.points).echoes > 2 ? 2 : 1),
      imu_(rig.motion, lidar.T_base_sensor, draw_imu_errors(seed, device.sensor)) {}

PacketBlock PacketRenderer::render(std::int64_t index) const {
  const Interval block{static_cast<double>(index) * block_s,
                       std::min(static_cast<double>(index + 1) * block_s, rig_.motion.duration_s())};
  PacketBlock out;
  Random random(seed_,
                device_stream * static_cast<std::uint64_t>(device_.sensor + 1) + static_cast<std::uint64_t>(index));
  render_points(block, random, out);
  if (device_.has_imu) render_imu(block, random, out);
  return out;
}

void PacketRenderer::append(const std::vector<std::uint8_t>& packet, double sent_s, bool imu, Random& random,
                            PacketBlock& out) const {
  const double delay = path_.least_delay_s - path_.jitter_s * std::log(1.0 - random.uniform());
  out.packets.push_back({sent_s, delay, out.bytes.size(), packet.size(), imu});
  out.bytes.insert(out.bytes.end(), packet.begin(), packet.end());
}

void PacketRenderer::fill_packet(std::int64_t number, double start_s, double end_s, Random& random,
                                 std::vector<Point>& points, std::vector<Vector3d>& directions) const {
  const livox::RecordLayout& layout = livox::record_layout(device_.points);
  lidar_.scanner.directions(number * layout.slots, directions);
  const PacketMotion motion(rig_.motion.T_scene_base(start_s) * lidar_.T_base_sensor,
                            rig_.motion.T_scene_base(end_s) * lidar_.T_base_sensor);
  const RayCaster::People people = caster_.people_at(0.5 * (start_s + end_s));
  points.clear();
  SE3 pose = motion.start;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (motion.moves) pose = motion.at(static_cast<double>(i) / static_cast<double>(directions.size()));
    SE3 beam = pose;
    if (lidar_.wobble.amplitude_rad != 0.0) {
      const double shot_number = static_cast<double>(number * layout.slots) + static_cast<double>(i);
      beam.R = pose.R * lidar_.wobble.at(shot_number / lidar_.scanner.shots_per_s());
    }
    const Shot shot = meter_.measure(beam, directions[i], people, random);
    const int echoes = std::min(shot.count, static_cast<int>(layout.echoes));
    for (int e = 0; e < echoes; ++e) {
      const Echo echo =
          layout.echoes == 1 ? shot.single(device_.nearest_only) : shot.echoes[static_cast<std::size_t>(e)];
      points.push_back(to_point(shot.direction, echo));
      points.back().shot = static_cast<std::uint16_t>(i);
    }
  }
}

void PacketRenderer::render_points(const Interval& block, Random& random, PacketBlock& out) const {
  const livox::RecordLayout& layout = livox::record_layout(device_.points);
  const Series series = series_in(device_.clock, block.start_s, block.end_s, device_.packet_interval_ns);
  std::vector<Vector3d> directions(layout.slots);
  std::vector<Point> points;
  std::vector<std::uint8_t> packet;
  livox::SampleHeader header;
  header.lidar_id = device_.lidar_id;
  header.data_type = device_.points;
  for (std::int64_t number = series.first; number < series.end; ++number) {
    header.device_stamp_ns = device_.clock.stamp_at_zero_ns + number * device_.packet_interval_ns;
    const double start_s = device_.clock.true_s(header.device_stamp_ns);
    const double end_s = device_.clock.true_s(header.device_stamp_ns + device_.packet_interval_ns);
    fill_packet(number, start_s, end_s, random, points, directions);
    livox::encode_points(header, points, packet);
    append(packet, end_s, false, random, out);
  }
}

void PacketRenderer::render_imu(const Interval& block, Random& random, PacketBlock& out) const {
  const std::int64_t step_ns = ns_of_seconds(imu_interval_s);
  const Series series = series_in(device_.clock, block.start_s, block.end_s, step_ns);
  std::vector<std::uint8_t> packet;
  livox::SampleHeader header;
  header.lidar_id = device_.lidar_id;
  header.data_type = livox::DataType::imu;
  for (std::int64_t number = series.first; number < series.end; ++number) {
    header.device_stamp_ns = device_.clock.stamp_at_zero_ns + number * step_ns;
    const double time_s = device_.clock.true_s(header.device_stamp_ns);
    const Vector3d gyro = imu_.read_gyro(time_s, random);
    const Vector3d acceleration = imu_.read_accelerometer_g(time_s, random);
    livox::ImuReading reading;
    for (int axis = 0; axis < 3; ++axis) {
      reading.gyro_rad_s[static_cast<std::size_t>(axis)] = static_cast<float>(gyro[axis]);
      reading.acceleration_g[static_cast<std::size_t>(axis)] = static_cast<float>(acceleration[axis]);
    }
    livox::encode_imu(header, reading, packet);
    append(packet, time_s, true, random, out);
  }
}

}  // namespace rigcal::sim
