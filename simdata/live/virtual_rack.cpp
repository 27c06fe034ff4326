#include "simdata/live/virtual_rack.h"

#include <algorithm>
#include <utility>

#include "core/base/seconds.h"

namespace rigcal::sim {
namespace {

constexpr std::int64_t shortest_wait_ns = 200'000;  // Packets leave in small groups, not one by one.
constexpr std::int64_t longest_wait_ns = 50'000'000;
constexpr std::size_t batch_datagrams = 32;

Error no_such_lidar(const Incident& incident) {
  return input_error("there is no LiDAR '" + incident.sensor + "' among the devices", "incident",
                     "name a LiDAR of the rig file");
}

}  // namespace

Expected<VirtualRack::Sockets> VirtualRack::open_sockets(const RackDevice& device) {
  const auto open = [](const Endpoint& local) { return net::UdpSocket::open({local, false, true, 0, {}}); };
  auto control = open({device.point_source.ip, livox::kDevicePort});
  if (!control) return control.error();
  auto points = open(device.point_source);
  if (!points) return points.error();
  auto imu = open(device.imu_source);
  if (!imu) return imu.error();
  return Sockets{*std::move(control), *std::move(points), *std::move(imu)};
}

Expected<std::unique_ptr<VirtualRack>> VirtualRack::open(std::vector<RackDevice> devices, RackOptions options) {
  for (const Incident& incident : options.incidents) {
    if (std::none_of(devices.begin(), devices.end(),
                     [&incident](const RackDevice& device) { return device.name == incident.sensor; }))
      return no_such_lidar(incident);
  }
  const std::int64_t now_ns = monotonic_now_ns();
  std::vector<Unit> units;
  std::vector<int> descriptors;
  for (RackDevice& device : devices) {
    auto sockets = open_sockets(device);
    if (!sockets) return sockets.error();
    descriptors.push_back(sockets->control.descriptor());
    VirtualLivox control(device.firmware, now_ns);
    units.push_back({std::move(device), *std::move(sockets), std::move(control), now_ns, 0});
  }
  auto waiter = net::Waiter::create(descriptors);
  if (!waiter) return waiter.error();
  return std::unique_ptr<VirtualRack>(
      new VirtualRack(std::move(units), *std::move(waiter), std::move(options), now_ns));
}

VirtualRack::VirtualRack(std::vector<Unit> units, net::Waiter waiter, RackOptions options, std::int64_t now_ns)
    : units_(std::move(units)),
      waiter_(std::move(waiter)),
      options_(std::move(options)),
      happened_(options_.incidents.size(), false),
      switched_on_ns_(now_ns),
      batch_(batch_datagrams),
      faults_(options_.packets, options_.seed, [this](const Datagram& datagram) -> Expected<void> {
        leave(datagram);
        return {};
      }) {}

void VirtualRack::happen(std::int64_t now_ns) {
  for (std::size_t i = 0; i < options_.incidents.size(); ++i) {
    const Incident& incident = options_.incidents[i];
    const std::int64_t start_ns = switched_on_ns_ + ns_of_seconds(incident.time_s);
    const auto unit = std::find_if(units_.begin(), units_.end(),
                                   [&incident](const Unit& other) { return other.device.name == incident.sensor; });
    if (incident.kind == Incident::Kind::owned_by_other) {
      unit->control.set_owned_by_other(now_ns >= start_ns && now_ns < start_ns + ns_of_seconds(incident.length_s));
    } else if (!happened_[i] && now_ns >= start_ns) {
      happened_[i] = true;
      happen_once(incident, *unit, now_ns);
    }
  }
}

void VirtualRack::happen_once(const Incident& incident, Unit& unit, std::int64_t now_ns) {
  switch (incident.kind) {
    case Incident::Kind::reboot:
      unit.control.reboot(now_ns);
      break;
    case Incident::Kind::silence:
      unit.control.fall_silent(switched_on_ns_ + ns_of_seconds(incident.time_s + incident.length_s));
      break;
    case Incident::Kind::status:
      unit.control.set_status(incident.status);
      break;
    case Incident::Kind::clock_jump:
      unit.clock_shift_ns += ns_of_seconds(incident.length_s);
      break;
    case Incident::Kind::refusal:
      unit.control.refuse(incident.refused);
      break;
    case Incident::Kind::owned_by_other:
      break;  // Has a beginning and an end.
  }
}

void VirtualRack::serve(std::int64_t now_ns) {
  happen(now_ns);
  for (Unit& unit : units_) {
    frames_.clear();
    unit.control.tick(now_ns, frames_);
    const auto count = unit.sockets.control.receive(batch_);
    for (std::size_t i = 0; count && i < *count; ++i)
      unit.control.receive(now_ns, batch_[i].from, batch_[i].bytes, frames_);
    // A frame that cannot be sent is one that got lost: hosts ask again.
    for (const DeviceFrame& frame : frames_) static_cast<void>(unit.sockets.control.send(frame.to, frame.bytes));
    if (unit.control.booted_ns() == unit.booted_ns) continue;
    unit.booted_ns = unit.control.booted_ns();
    unit.clock_shift_ns = 0;
  }
}

void VirtualRack::wait(std::int64_t until_ns) {
  for (const Unit& unit : units_) until_ns = std::min(until_ns, unit.control.deadline_ns());
  const std::int64_t left_ns = until_ns - monotonic_now_ns();
  waiter_.wait(std::clamp(left_ns, shortest_wait_ns, longest_wait_ns));
}

bool VirtualRack::is_any_sampling() const {
  return std::any_of(units_.begin(), units_.end(), [](const Unit& unit) { return unit.control.is_sampling(); });
}

bool VirtualRack::are_all_sampling() const {
  return std::all_of(units_.begin(), units_.end(), [](const Unit& unit) { return unit.control.is_sampling(); });
}

bool VirtualRack::may_begin(std::int64_t now_ns, double patience_s) {
  if (!first_sampling_ns_ && is_any_sampling()) first_sampling_ns_ = now_ns;
  if (!first_sampling_ns_) return false;
  return are_all_sampling() || now_ns - *first_sampling_ns_ >= ns_of_seconds(patience_s);
}

bool VirtualRack::send(std::size_t index, std::int64_t due_ns, bool imu, ByteView bytes) {
  const Unit& unit = units_[index];
  if (!unit.control.is_sampling() || unit.control.is_silent(due_ns)) return false;
  if (imu && !unit.control.settings().sends_imu()) return false;
  const VirtualLivox::Owner& owner = *unit.control.owner();
  static_cast<void>(faults_.add({due_ns,
                                 imu ? unit.device.imu_source : unit.device.point_source,
                                 {owner.ip, imu ? owner.imu_port : owner.data_port},
                                 bytes}));
  return true;
}

void VirtualRack::leave(const Datagram& datagram) {
  const auto unit = std::find_if(units_.begin(), units_.end(), [&datagram](const Unit& other) {
    return other.device.point_source.ip == datagram.from.ip;
  });
  RIGCAL_ASSERT(unit != units_.end(), "a packet of no device");
  const bool imu = datagram.from.port == unit->device.imu_source.port;
  const auto sent = (imu ? unit->sockets.imu : unit->sockets.points).send(datagram.to, datagram.bytes);
  ++counts_.packets;
  counts_.bytes += datagram.bytes.size();
  // One host's address or port that leads nowhere ends nothing: the others go on.
  if (!sent || !*sent) ++counts_.unsent;
}

FaultCounts VirtualRack::faults(std::size_t index) const {
  FaultCounts all;
  for (const Endpoint& from : {units_[index].device.point_source, units_[index].device.imu_source}) {
    const auto found = faults_.counts().find(from);
    if (found == faults_.counts().end()) continue;
    all.sent += found->second.sent;
    all.lost += found->second.lost;
    all.duplicated += found->second.duplicated;
    all.out_of_order += found->second.out_of_order;
    all.delayed += found->second.delayed;
    all.flipped += found->second.flipped;
  }
  return all;
}

}  // namespace rigcal::sim
