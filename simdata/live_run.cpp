#include "simdata/live_run.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "drivers/net/session_clock.h"
#include "drivers/net/udp_socket.h"
#include "drivers/net/waiter.h"
#include "simdata/camera_units.h"
#include "simdata/live_stamp.h"
#include "simdata/render_ahead.h"

namespace rigcal::sim {
namespace {

constexpr std::int64_t lead_ns = 20'000'000;        // From the first "start" to the first shot.
constexpr std::int64_t shortest_wait_ns = 200'000;  // Packets leave in small groups, not one by one.
constexpr std::int64_t longest_wait_ns = 50'000'000;
constexpr std::int64_t render_wait_ns = 2'000'000;      // Until a block that is not rendered yet is looked for again.
constexpr std::int64_t last_frames_ns = 5'000'000'000;  // The run's last images may take so long after its end.
constexpr double late_s = 0.1;                          // From here on the rendering is too slow for what is asked.

std::int64_t now_ns() { return net::read_clocks().monotonic_ns; }

struct Sockets {
  net::UdpSocket control;
  net::UdpSocket points;
  net::UdpSocket imu;
};

Expected<Sockets> open_sockets(const SimDevice& device) {
  const auto open = [](const Endpoint& local) { return net::UdpSocket::open({local, false, true, 0, {}}); };
  auto control = open({device.point_source.ip, livox::kDevicePort});
  if (!control) return control.error();
  auto points = open(device.point_source);
  if (!points) return points.error();
  auto imu = open(device.imu_source);
  if (!imu) return imu.error();
  return Sockets{*std::move(control), *std::move(points), *std::move(imu)};
}

class LiveRun {
 public:
  LiveRun(const SimulatedRig& simulated, std::vector<SimDevice> devices, std::vector<Sockets> sockets,
          net::Waiter waiter, const Rig& rig, const Endpoint& broadcast_to, const LiveOptions& options,
          RenderAhead& ahead, LiveCameras& cameras)
      : options_(options),
        duration_s_(simulated.motion.duration_s()),
        ahead_(ahead),
        cameras_(cameras),
        waiter_(std::move(waiter)),
        batch_(32),
        faults_(options.run.faults, options.run.seed,
                [this](const Datagram& datagram) { return send_packet(datagram); }),
        switched_on_ns_(now_ns()) {
    summary_.stops = simulated.motion.stop_count();
    for (std::size_t i = 0; i < devices.size(); ++i) {
      VirtualLivoxOptions unit = options.device;
      unit.identity = devices[i].broadcast;
      unit.ip = devices[i].point_source.ip;
      unit.broadcast_to = broadcast_to;
      unit.faults = options.control;
      unit.seed = options.run.seed + i;
      const std::string& name = rig.sensors[static_cast<std::size_t>(devices[i].sensor)].name;
      units_.push_back(std::make_unique<Unit>(std::move(devices[i]), std::move(sockets[i]), name,
                                              VirtualLivox(unit, switched_on_ns_)));
      units_.back()->control.wake_with(units_.back()->device.points, units_.back()->device.nearest_only);
    }
  }

  Expected<LiveSummary> run(const RunContext& context) {
    while (!context.cancelled()) {
      const std::int64_t now = now_ns();
      happen(now);
      for (const auto& unit : units_) serve(*unit, now);
      if (!start_ns_ && is_any_sampling()) {
        start_ns_ = now + lead_ns;
        cameras_.begin(*start_ns_, options_.speed, options_.loop);
      }
      cameras_.tick(now);
      if (start_ns_) {
        if (const auto sent = send_due(now); !sent) return sent.error();
        const double run_s = std::max(0.0, static_cast<double>(now - *start_ns_) * 1e-9 * options_.speed);
        summary_.seconds = options_.loop ? run_s : std::min(run_s, duration_s_);
        context.reporter.progress("serve", options_.loop ? -1.0 : summary_.seconds / duration_s_);
        if (summary_.latest_s > late_s)
          context.reporter.warn(
              "packets leave more than 0.1 s late: this machine cannot render and send that fast; lower the speed");
        if (is_over(now)) {
          summary_.is_complete = true;
          break;
        }
      }
      waiter_.wait(std::clamp(next_ns() - now_ns(), shortest_wait_ns, longest_wait_ns));
    }
    if (const auto flushed = faults_.flush(); !flushed) return flushed.error();
    count_faults();
    summary_.cameras = cameras_.summary();
    return summary_;
  }

 private:
  struct Unit {
    Unit(SimDevice simulated, Sockets opened, std::string sensor, VirtualLivox firmware)
        : device(std::move(simulated)),
          sockets(std::move(opened)),
          name(std::move(sensor)),
          control(std::move(firmware)),
          booted_ns(control.booted_ns()) {}
    SimDevice device;
    Sockets sockets;
    std::string name;
    VirtualLivox control;
    std::int64_t booted_ns;
    std::int64_t boot_stamp_ns = 0;
    std::unique_ptr<LiveBlock> block;
    std::vector<std::size_t> order;  ///< Of the block's packets, by when they are sent.
    std::size_t next = 0;
  };

  void happen(std::int64_t now) {
    for (std::size_t i = 0; i < options_.incidents.size(); ++i) {
      const Incident& incident = options_.incidents[i];
      const auto at = [&](double time_s) { return switched_on_ns_ + std::llround(time_s * 1e9); };
      for (const auto& unit : units_) {
        if (unit->name != incident.sensor) continue;
        if (incident.kind == Incident::Kind::owned_by_other) {
          const bool owned = now >= at(incident.time_s) && now < at(incident.time_s + incident.length_s);
          unit->control.set_owned_by_other(owned);
        } else if (i >= happened_.size() || !happened_[i]) {
          if (now < at(incident.time_s)) continue;
          happened_.resize(std::max(happened_.size(), i + 1), false);
          happened_[i] = true;
          if (incident.kind == Incident::Kind::reboot) unit->control.reboot(now);
          if (incident.kind == Incident::Kind::status) unit->control.set_status(incident.status);
          if (incident.kind == Incident::Kind::silence)
            unit->control.fall_silent(at(incident.time_s + incident.length_s));
        }
      }
    }
  }

  void serve(Unit& unit, std::int64_t now) {
    frames_.clear();
    unit.control.tick(now, frames_);
    const auto count = unit.sockets.control.receive(batch_);
    for (std::size_t i = 0; count && i < *count; ++i)
      unit.control.receive(now, batch_[i].from, batch_[i].bytes, frames_);
    for (const DeviceFrame& frame : frames_) static_cast<void>(unit.sockets.control.send(frame.to, frame.bytes));
    const std::size_t index = index_of(unit);
    ahead_.set_points(index, unit.control.settings().point_type(), unit.control.settings().nearest_only());
    if (unit.control.booted_ns() != unit.booted_ns) {
      unit.booted_ns = unit.control.booted_ns();
      const double run_s =
          start_ns_ ? static_cast<double>(unit.booted_ns - *start_ns_) * 1e-9 : 0.0;  // Of the host's time.
      unit.boot_stamp_ns = unit.device.clock.stamp_ns(run_s);
    }
  }
  std::size_t index_of(const Unit& unit) const {
    const auto found =
        std::find_if(units_.begin(), units_.end(), [&](const auto& other) { return other.get() == &unit; });
    return static_cast<std::size_t>(found - units_.begin());
  }
  bool is_any_sampling() const {
    if (units_.empty()) return cameras_.is_any_acquiring();
    return std::any_of(units_.begin(), units_.end(), [](const auto& unit) { return unit->control.is_sampling(); });
  }

  double earlier_s(const LiveBlock& block) const {
    return static_cast<double>(block.number / ahead_.blocks_of_a_run()) * duration_s_;
  }
  std::int64_t due_ns(const Unit& unit) const {
    const PacketBlock::Packet& packet = unit.block->packets.packets[unit.order[unit.next]];
    return *start_ns_ + std::llround((earlier_s(*unit.block) + packet.sent_s + packet.delay_s) / options_.speed * 1e9);
  }
  // Makes sure that the unit has a packet to send, where one is rendered.
  bool has_next(Unit& unit) {
    while (!unit.block || unit.next >= unit.order.size()) {
      unit.block = ahead_.take(index_of(unit));
      if (!unit.block) return false;
      const auto& packets = unit.block->packets.packets;
      unit.order.resize(packets.size());
      for (std::size_t i = 0; i < packets.size(); ++i) unit.order[i] = i;
      std::stable_sort(unit.order.begin(), unit.order.end(), [&packets](std::size_t a, std::size_t b) {
        return packets[a].sent_s + packets[a].delay_s < packets[b].sent_s + packets[b].delay_s;
      });
      unit.next = 0;
    }
    return true;
  }

  Expected<void> send_due(std::int64_t now) {
    for (const auto& unit : units_) {
      while (has_next(*unit)) {
        const std::int64_t due = due_ns(*unit);
        if (due > now) break;
        const auto sent = send_next(*unit, due);
        if (!sent) return sent.error();
        summary_.latest_s = std::max(summary_.latest_s, static_cast<double>(now - due) * 1e-9);
      }
    }
    return {};
  }

  Expected<void> send_next(Unit& unit, std::int64_t due) {
    const PacketBlock::Packet& packet = unit.block->packets.packets[unit.order[unit.next++]];
    if (!unit.control.is_sampling() || unit.control.is_silent(due)) return {};
    const VirtualSettings& settings = unit.control.settings();
    if (packet.imu ? !settings.sends_imu() : settings.point_type() != unit.block->points) return {};
    const std::span<std::uint8_t> bytes(unit.block->packets.bytes.data() + packet.offset, packet.size);
    make_live({options_.speed, earlier_s(*unit.block), unit.boot_stamp_ns}, unit.device.clock, unit.control.status(),
              packet.imu, bytes);
    const VirtualLivox::Owner& owner = *unit.control.owner();
    return faults_.add({due,
                        packet.imu ? unit.device.imu_source : unit.device.point_source,
                        {owner.ip, packet.imu ? owner.imu_port : owner.data_port},
                        bytes});
  }

  Expected<void> send_packet(const Datagram& datagram) {
    for (const auto& unit : units_) {
      if (unit->device.point_source.ip != datagram.from.ip) continue;
      const bool imu = datagram.from.port == unit->device.imu_source.port;
      const auto sent = (imu ? unit->sockets.imu : unit->sockets.points).send(datagram.to, datagram.bytes);
      if (!sent) return sent.error();
      ++summary_.packets;
      summary_.bytes += datagram.bytes.size();
      if (!*sent) ++summary_.unsent;
    }
    return {};
  }

  bool is_over(std::int64_t now) {
    const std::int64_t end_ns = *start_ns_ + std::llround(duration_s_ / options_.speed * 1e9);
    if (options_.loop || now < end_ns || !ahead_.is_over()) return false;
    if (std::any_of(units_.begin(), units_.end(), [this](const auto& unit) { return has_next(*unit); })) return false;
    return cameras_.is_idle() || now >= end_ns + last_frames_ns;
  }
  std::int64_t next_ns() {
    std::int64_t next = INT64_MAX;
    for (const auto& unit : units_) {
      next = std::min(next, unit->control.deadline_ns());
      if (!start_ns_) continue;
      next = std::min(next, has_next(*unit) ? due_ns(*unit) : now_ns() + render_wait_ns);
    }
    return next;
  }
  void count_faults() {
    for (const auto& unit : units_) {
      FaultCounts all;
      for (const Endpoint& from : {unit->device.point_source, unit->device.imu_source}) {
        const auto found = faults_.counts().find(from);
        if (found == faults_.counts().end()) continue;
        all.sent += found->second.sent;
        all.lost += found->second.lost;
        all.duplicated += found->second.duplicated;
        all.out_of_order += found->second.out_of_order;
        all.delayed += found->second.delayed;
        all.flipped += found->second.flipped;
      }
      summary_.faults.push_back(all);
    }
  }

  const LiveOptions& options_;
  double duration_s_;
  RenderAhead& ahead_;
  LiveCameras& cameras_;
  net::Waiter waiter_;
  net::ReceiveBatch batch_;
  PacketFaults faults_;
  std::int64_t switched_on_ns_;
  std::vector<std::unique_ptr<Unit>> units_;
  std::vector<bool> happened_;
  std::vector<DeviceFrame> frames_;
  std::optional<std::int64_t> start_ns_;
  LiveSummary summary_;
};

Error unknown_sensor(const Incident& incident) {
  return input_error("there is no device '" + incident.sensor + "' to which that could happen", "incident",
                     "name a LiDAR of the rig file, or a camera whose driver is aravis; cameras have no status word");
}

bool can_happen(const Incident& incident, const Rig& rig) {
  const int sensor = rig.find(incident.sensor);
  if (sensor < 0) return false;
  const Sensor& found = rig.sensors[static_cast<std::size_t>(sensor)];
  return found.is_lidar() || (is_served(found) && incident.kind != Incident::Kind::status);
}

}  // namespace

Expected<LiveSummary> serve_live(const Scene& scene, const Rig& rig, const LiveOptions& options,
                                 const RunContext& context) {
  auto devices = make_devices(rig, options.run.seed, options.run.clock_drift_ppm);
  if (!devices) return devices.error();
  for (const Incident& incident : options.incidents) {
    if (!can_happen(incident, rig)) return unknown_sensor(incident);
  }
  const auto host = host_address(rig);
  if (!host) return host.error();
  const auto simulated = make_simulated_rig(rig, scene.T_scene_table, options.run.turntable, options.run.mount_error,
                                            options.run.seed, options.run.unit_errors);
  if (!simulated) return simulated.error();
  std::vector<Sockets> sockets;
  std::vector<int> descriptors;
  for (SimDevice& device : *devices) {
    auto opened = open_sockets(device);
    if (!opened) return opened.error();
    descriptors.push_back(opened->control.descriptor());
    sockets.push_back(*std::move(opened));
    // Whether it sends them is up to its owner.
    device.has_imu = livox::has_imu(device.broadcast.type);
  }
  auto waiter = net::Waiter::create(descriptors);
  if (!waiter) return waiter.error();
  const bool loopback = (*host)[0] == 127;
  const Endpoint broadcast_to{loopback ? *host : livox::Ipv4{255, 255, 255, 255}, options.discovery_port};
  const RayCaster caster(scene);
  RenderAhead ahead(caster, scene.materials, *simulated, *devices, options.run.path, options.run.seed, options.loop);
  const auto cameras =
      LiveCameras::start(scene, caster, rig, *simulated, options.run, options.cameras, options.incidents);
  if (!cameras) return cameras.error();
  LiveRun run(*simulated, *std::move(devices), std::move(sockets), *std::move(waiter), rig, broadcast_to, options,
              ahead, **cameras);
  return run.run(context);
}

}  // namespace rigcal::sim
