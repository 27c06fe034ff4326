#include "apps/ingest/lidar_ingest.h"

#include <algorithm>
#include <utility>

#include "apps/ingest/lidar_findings.h"
#include "apps/ingest/point_filter.h"
#include "apps/ingest/unit_numbers.h"
#include "core/clocks/pulse_time.h"
#include "drivers/livox_codec/sample_packet.h"

namespace rigcal {
namespace {

// A rig has a dozen sensors; more addresses than this are somebody's noise and are not told apart.
constexpr std::size_t max_devices = 256;
constexpr double imu_interval_ns = 5e6;  // 200 Hz.

struct Device {
  DeviceIngest counts;
  DeviceClock clock;
  PulseTime pulse;
  UnitNumbers slots;  ///< Ten times the Hub's slot, and the unit there.
  StreamLedger points;
  StreamLedger imu;
  std::optional<std::uint16_t> imu_port;  ///< Where its IMU packets come from, when that is not where its points do.
  LidarModel model = LidarModel::other;
  PointFilter filter;
};

LidarModel model_of(const Rig& rig, const DeviceIngest& device) {
  if (device.type) return livox::lidar_model(*device.type);
  return device.sensor < 0 ? LidarModel::other : rig.sensors[static_cast<std::size_t>(device.sensor)].lidar->model;
}

// Whatever a rig file says: points without tags are sent by a MID-40, and it sends no others.
double shot_interval_ns(LidarModel model, livox::DataType type) {
  const bool has_tags = type != livox::DataType::cartesian && type != livox::DataType::spherical;
  if (!has_tags) model = LidarModel::livox_mid40;
  if (has_tags && model == LidarModel::livox_mid40) model = LidarModel::other;
  return 1e9 / facts_of(model).shots_per_s;
}

/// Takes echoes out that say the same as the one before them of their shot: a device that saw one surface only and
/// fills the packet up with it would give that surface the weight of two.
void drop_repeated(Device& device, std::vector<Point>& points) {
  const auto repeats = [](const Point& before, const Point& point) {
    return before.shot == point.shot && before.x == point.x && before.y == point.y && before.z == point.z;
  };
  const auto end = std::unique(points.begin(), points.end(), repeats);
  device.counts.repeated += static_cast<std::uint64_t>(points.end() - end);
  points.erase(end, points.end());
}

}  // namespace

class LidarIngest::Devices {
 public:
  Devices(const Rig& rig, PointSink points, ImuSink imu, const BroadcastCodes& codes, bool headers_only)
      : rig_(rig),
        point_sink_(std::move(points)),
        imu_sink_(std::move(imu)),
        codes_(codes),
        headers_only_(headers_only) {
    batch_.points.reserve(livox::kMaxSlots);
  }

  void learn(const Datagram& datagram);
  void add(const Datagram& datagram);
  [[nodiscard]] IngestSummary summary() const;
  [[nodiscard]] std::optional<Error> shared() const;

  const Rig& rig() const { return rig_; }
  const BroadcastCodes& codes() const { return codes_; }
  bool learned_too_late() const { return too_late_; }

 private:
  Device* find(const IpAddress& ip);
  Device* find_or_add(const IpAddress& ip);
  void assign(Device& device);
  void learn(const livox::ControlFrame& frame, const IpAddress& from);
  void count(const livox::ControlFrame& frame, const Datagram& datagram);
  void add_packet(Device& device, const livox::SamplePacket& packet, std::int64_t received_ns);
  void add_points(Device& device, const livox::SamplePacket& packet, std::int64_t stamp_ns);
  void add_imu(Device& device, const livox::SamplePacket& packet, std::int64_t stamp_ns);

  Rig rig_;
  PointSink point_sink_;
  ImuSink imu_sink_;
  BroadcastCodes codes_;
  bool headers_only_;
  std::map<IpAddress, Device> devices_;
  /// Also of addresses that were only talked to so far.
  std::map<IpAddress, std::map<std::string, std::uint64_t>> control_frames_;
  IngestSummary totals_;
  bool too_late_ = false;
  PointBatch batch_;
};

Device* LidarIngest::Devices::find(const IpAddress& ip) {
  const auto found = devices_.find(ip);
  return found == devices_.end() ? nullptr : &found->second;
}

Device* LidarIngest::Devices::find_or_add(const IpAddress& ip) {
  if (Device* known = find(ip)) return known;
  if (devices_.size() >= max_devices && sensor_at(rig_, codes_, ip) < 0) return nullptr;
  Device& device = devices_[ip];
  device.counts.ip = ip;
  assign(device);
  return &device;
}

void LidarIngest::Devices::assign(Device& device) {
  const int sensor = sensor_at(rig_, codes_, device.counts.ip);
  if (sensor != device.counts.sensor && device.counts.packets > 0) too_late_ = true;
  device.counts.sensor = sensor;
  const auto told = codes_.find(device.counts.ip);
  if (told != codes_.end()) device.counts.broadcast_code = told->second;
  device.model = model_of(rig_, device.counts);
  device.filter =
      sensor < 0 ? PointFilter() : PointFilter(true, rig_.sensors[static_cast<std::size_t>(sensor)].lidar->range_m);
}

void LidarIngest::Devices::learn(const Datagram& datagram) {
  if (datagram.bytes.empty() || datagram.bytes[0] != 0xAA) return;
  if (const auto frame = livox::parse_control_frame(datagram.bytes)) learn(*frame, datagram.from.ip);
}

void LidarIngest::Devices::learn(const livox::ControlFrame& frame, const IpAddress& from) {
  if (!livox::is_broadcast(frame)) return;
  const Expected<livox::Broadcast> broadcast = livox::parse_broadcast(frame);
  if (!broadcast) return;
  if (codes_.size() >= max_devices && !codes_.contains(from) && sensor_by_ip(rig_, from) < 0) return;
  std::string& code = codes_[from];
  const bool news = code != broadcast->broadcast_code;
  code = broadcast->broadcast_code;
  Device* device = find_or_add(from);
  if (device == nullptr) return;
  device->counts.type = broadcast->type;
  if (news) {
    for (auto& [ip, each] : devices_) assign(each);
  } else {
    assign(*device);
  }
}

void LidarIngest::Devices::count(const livox::ControlFrame& frame, const Datagram& datagram) {
  ++totals_.control_frames;
  const bool request = livox::is_request(frame);
  const IpAddress& ip = request ? datagram.to.ip : datagram.from.ip;
  // A broadcast is looked at more closely (`learn`) before its sender counts as a device.
  if (!request && !livox::is_broadcast(frame)) static_cast<void>(find_or_add(ip));
  if (control_frames_.size() >= max_devices && !control_frames_.contains(ip) && sensor_at(rig_, codes_, ip) < 0) return;
  ++control_frames_[ip][livox::frame_name(frame)];
}

void LidarIngest::Devices::add(const Datagram& datagram) {
  ++totals_.datagrams;
  if (!datagram.bytes.empty() && datagram.bytes[0] == 0xAA) {
    if (const auto frame = livox::parse_control_frame(datagram.bytes)) {
      count(*frame, datagram);
      learn(*frame, datagram.from.ip);
      return;
    }
  }
  if (const auto packet = livox::parse_sample_packet(datagram.bytes)) {
    if (Device* device = find_or_add(datagram.from.ip)) {
      // Real devices send each stream from a port of its own, by which a damaged packet is told.
      if (packet->header.data_type == livox::DataType::imu) {
        device->imu_port = datagram.from.port;
      } else if (device->imu_port == datagram.from.port) {
        device->imu_port.reset();
      }
      add_packet(*device, *packet, datagram.stamp_ns);
    }
    return;
  }
  if (Device* device = find(datagram.from.ip)) {
    ++device->counts.malformed;
    (datagram.from.port == device->imu_port ? device->imu : device->points).add_damaged();
  } else {
    ++totals_.not_livox;
  }
}

void LidarIngest::Devices::add_packet(Device& device, const livox::SamplePacket& packet, std::int64_t received_ns) {
  const livox::SampleHeader& header = packet.header;
  DeviceIngest& counts = device.counts;
  ++counts.packets;
  if ((header.status >> 30U) > (counts.worst_status >> 30U) || counts.packets == 1) counts.worst_status = header.status;
  device.slots.add(10 * header.slot + header.lidar_id);
  std::int64_t device_ns = header.device_stamp_ns;
  if (header.timestamp_type == livox::TimestampType::pps_only) device_ns = device.pulse.add(device_ns, received_ns);
  const SessionStamp stamp = device.clock.add(device_ns, received_ns);
  if (stamp.jumped) {
    device.points.restart();
    device.imu.restart();
  }
  const bool imu = header.data_type == livox::DataType::imu;
  StreamLedger& ledger = imu ? device.imu : device.points;
  if (stamp.stray) {
    ledger.add_damaged();
    ++counts.unused_packets;
    return;
  }
  const double interval =
      imu ? imu_interval_ns
          : shot_interval_ns(device.model, header.data_type) * livox::record_layout(header.data_type).slots;
  if (ledger.add(device_ns, interval, stamp.stamp_ns) == Arrival::duplicate) {
    ++counts.unused_packets;
    return;
  }
  if (counts.last_ns == 0) counts.first_ns = stamp.stamp_ns;
  counts.last_ns = std::max(counts.last_ns, stamp.stamp_ns);
  if (headers_only_) return;
  if (imu) {
    add_imu(device, packet, stamp.stamp_ns);
  } else {
    add_points(device, packet, stamp.stamp_ns);
  }
}

void LidarIngest::Devices::add_points(Device& device, const livox::SamplePacket& packet, std::int64_t stamp_ns) {
  batch_.sensor = device.counts.sensor;
  batch_.stamp_ns = stamp_ns;
  batch_.shot_interval_ns = shot_interval_ns(device.model, packet.header.data_type);
  batch_.shots = livox::record_layout(packet.header.data_type).slots;
  livox::decode_points(packet, batch_.points);
  if (livox::record_layout(packet.header.data_type).echoes > 1) drop_repeated(device, batch_.points);
  const PointFilter::LeftOut left_out = device.filter.apply(batch_.points);
  device.counts.noise += left_out.noise;
  device.counts.out_of_range += left_out.out_of_range;
  device.counts.points += batch_.points.size();
  device.counts.shots += batch_.shots;
  if (point_sink_ && device.counts.sensor >= 0) point_sink_(batch_);
}

void LidarIngest::Devices::add_imu(Device& device, const livox::SamplePacket& packet, std::int64_t stamp_ns) {
  const Expected<livox::ImuReading> reading = livox::decode_imu(packet);
  if (!reading) {
    device.imu.add_damaged();
    ++device.counts.unused_packets;
    return;
  }
  ++device.counts.imu_samples;
  if (!imu_sink_ || device.counts.sensor < 0) return;
  const auto& gyro = reading->gyro_rad_s;
  const auto& acceleration = reading->acceleration_g;
  imu_sink_({device.counts.sensor, stamp_ns, Vector3d(gyro[0], gyro[1], gyro[2]),
             Vector3d(acceleration[0], acceleration[1], acceleration[2])});
}

IngestSummary LidarIngest::Devices::summary() const {
  IngestSummary summary = totals_;
  for (const auto& [ip, device] : devices_) {
    DeviceIngest& counts = summary.devices.emplace_back(device.counts);
    counts.clock = device.clock.figures();
    counts.point_stream = device.points.book();
    counts.imu_stream = device.imu.book();
    const auto talk = control_frames_.find(ip);
    if (talk != control_frames_.end()) counts.control_frames = talk->second;
  }
  summary.warnings = ingest_warnings(rig_, summary);
  summary.unfit = shared();
  if (!summary.unfit) summary.unfit = ingest_error(rig_, summary, false);
  return summary;
}

/// A LiDAR's address from which the packets of several come: that of a Hub.
std::optional<Error> LidarIngest::Devices::shared() const {
  for (const auto& [ip, device] : devices_) {
    if (device.counts.sensor < 0 || !device.slots.several()) continue;
    return input_error("several LiDARs send from " + to_string(ip) + " (slot and number there: " + device.slots.text() +
                           "), but " + rig_.sensors[static_cast<std::size_t>(device.counts.sensor)].name +
                           " is one; is it a Hub, whose packets are not read?",
                       {}, "connect the LiDARs without it");
  }
  return std::nullopt;
}

LidarIngest::LidarIngest(const Rig& rig, PointSink points, ImuSink imu, const BroadcastCodes& codes)
    : devices_(std::make_unique<Devices>(rig, std::move(points), std::move(imu), codes, false)) {}
LidarIngest LidarIngest::of_headers(const Rig& rig) {
  LidarIngest ingest(rig, {}, {});
  ingest.devices_ = std::make_unique<Devices>(rig, PointSink{}, ImuSink{}, BroadcastCodes{}, true);
  return ingest;
}

LidarIngest::~LidarIngest() = default;
LidarIngest::LidarIngest(LidarIngest&&) noexcept = default;
LidarIngest& LidarIngest::operator=(LidarIngest&&) noexcept = default;

void LidarIngest::learn(const Datagram& datagram) { devices_->learn(datagram); }
void LidarIngest::add(const Datagram& datagram) { devices_->add(datagram); }
BroadcastCodes LidarIngest::codes() const { return devices_->codes(); }
bool LidarIngest::learned_too_late() const { return devices_->learned_too_late(); }
IngestSummary LidarIngest::summary() const { return devices_->summary(); }

Expected<IngestSummary> LidarIngest::finish() const {
  IngestSummary summary = devices_->summary();
  if (std::optional<Error> error = devices_->shared()) return *error;
  if (std::optional<Error> error = ingest_error(devices_->rig(), summary, devices_->learned_too_late())) return *error;
  return summary;
}

const DeviceIngest* IngestSummary::of_sensor(int sensor) const {
  const DeviceIngest* found = nullptr;
  for (const DeviceIngest& device : devices) {
    if (device.sensor == sensor && (found == nullptr || device.packets > found->packets)) found = &device;
  }
  return found;
}

}  // namespace rigcal
