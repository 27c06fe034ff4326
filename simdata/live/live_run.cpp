#include "simdata/live/live_run.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/base/seconds.h"
#include "drivers/net/session_clock.h"
#include "simdata/live/camera_units.h"
#include "simdata/live/live_stamp.h"
#include "simdata/live/render_ahead.h"
#include "simdata/live/virtual_table.h"

namespace rigcal::sim {
namespace {

constexpr std::int64_t lead_ns = 20'000'000;            // From the last "start" to the first shot.
constexpr std::int64_t render_wait_ns = 2'000'000;      // Until a block that is not rendered yet is looked for again.
constexpr std::int64_t last_frames_ns = 5'000'000'000;  // The run's last images may take so long after its end.
constexpr double late_s = 0.1;                          // From here on the rendering is too slow for what is asked.

class LiveRun {
 public:
  LiveRun(const std::vector<SimDevice>& devices, int stops, double duration_s, VirtualRack& rack, RenderAhead& ahead,
          LiveCameras& cameras, VirtualTable* table, const TurntableMotion& motion, const LiveOptions& options)
      : options_(options),
        table_(table),
        motion_(motion),
        duration_s_(duration_s),
        ahead_(ahead),
        cameras_(cameras),
        rack_(rack),
        units_(devices.size()) {
    summary_.stops = stops;
    for (std::size_t i = 0; i < devices.size(); ++i) {
      units_[i].device = devices[i];
      units_[i].booted_ns = rack.device(i).booted_ns();
      rack.device(i).wake_with(devices[i].points, devices[i].nearest_only);
    }
  }

  LiveSummary run(const RunContext& context) {
    while (!context.cancelled()) {
      const std::int64_t now = monotonic_now_ns();
      rack_.serve(now);
      for (std::size_t i = 0; i < units_.size(); ++i) follow(i);
      if (!start_ns_ && is_wanted(now)) {
        start_ns_ = now + lead_ns;
        cameras_.begin(*start_ns_, options_.speed, options_.loop);
      }
      cameras_.tick(now);
      if (start_ns_) {
        send_due(now);
        const double run_s = std::max(0.0, seconds_of_ns(now - *start_ns_) * options_.speed);
        summary_.seconds = options_.loop ? run_s : std::min(run_s, duration_s_);
        if (table_ != nullptr) turn_table(run_s);
        context.reporter.progress("serve", options_.loop ? -1.0 : summary_.seconds / duration_s_);
        if (summary_.latest_s > late_s)
          context.reporter.warn(
              "packets leave more than 0.1 s late: this machine cannot render and send that fast; lower the speed");
        if (is_over(now)) {
          summary_.is_complete = true;
          break;
        }
      }
      rack_.wait(next_ns());
    }
    rack_.flush();
    summary_.packets = rack_.counts().packets;
    summary_.bytes = rack_.counts().bytes;
    summary_.unsent = rack_.counts().unsent;
    for (std::size_t i = 0; i < units_.size(); ++i) summary_.faults.push_back(rack_.faults(i));
    summary_.cameras = cameras_.summary();
    return summary_;
  }

 private:
  void turn_table(double run_s) {
    if (options_.table_jams_s >= 0.0 && run_s >= options_.table_jams_s) table_->jam(true);
    const double turns = std::floor(run_s / duration_s_);
    table_->follow(to_deg(turns * motion_.angle_rad(duration_s_) + motion_.angle_rad(run_s - turns * duration_s_)));
  }

  struct Unit {
    SimDevice device;
    std::int64_t booted_ns = 0;
    std::int64_t boot_stamp_ns = 0;
    std::unique_ptr<LiveBlock> block;
    std::vector<std::size_t> order;  ///< Of the block's packets, by when they are sent.
    std::size_t next = 0;
    std::int64_t last_due_ns = 0;
  };

  bool is_wanted(std::int64_t now) {
    return units_.empty() ? cameras_.is_any_acquiring() : rack_.may_begin(now, options_.patience_s);
  }
  // What its owner has told the device, and whether it has restarted.
  void follow(std::size_t index) {
    Unit& unit = units_[index];
    const VirtualLivox& control = rack_.device(index);
    ahead_.set_points(index, control.settings().point_type(), control.settings().nearest_only());
    if (control.booted_ns() == unit.booted_ns) return;
    unit.booted_ns = control.booted_ns();
    const double run_s = start_ns_ ? seconds_of_ns(unit.booted_ns - *start_ns_) : 0.0;  // Of the host's time.
    unit.boot_stamp_ns = unit.device.clock.stamp_ns(run_s);
  }

  double earlier_s(const LiveBlock& block) const {
    return static_cast<double>(block.number / ahead_.blocks_of_a_run()) * duration_s_;
  }
  // When a true time of the block's run is, on this machine's clock.
  std::int64_t host_ns(const LiveBlock& block, double time_s) const {
    return *start_ns_ + ns_of_seconds((earlier_s(block) + time_s) / options_.speed);
  }
  // A device's packets go one way and do not overtake each other.
  std::int64_t due_ns(const Unit& unit) const {
    const PacketBlock::Packet& packet = unit.block->packets.packets[unit.order[unit.next]];
    return std::max(unit.last_due_ns, host_ns(*unit.block, packet.sent_s + packet.delay_s));
  }
  // Makes sure that the unit has a packet to send, where one is rendered.
  bool has_next(std::size_t index) {
    Unit& unit = units_[index];
    while (!unit.block || unit.next >= unit.order.size()) {
      unit.block = ahead_.take(index);
      if (!unit.block) return false;
      const auto& packets = unit.block->packets.packets;
      unit.order.resize(packets.size());
      for (std::size_t i = 0; i < packets.size(); ++i) unit.order[i] = i;
      std::stable_sort(unit.order.begin(), unit.order.end(),
                       [&packets](std::size_t a, std::size_t b) { return packets[a].sent_s < packets[b].sent_s; });
      unit.next = 0;
    }
    return true;
  }

  void send_due(std::int64_t now) {
    for (std::size_t i = 0; i < units_.size(); ++i) {
      while (has_next(i)) {
        const std::int64_t due = due_ns(units_[i]);
        if (due > now) break;
        units_[i].last_due_ns = due;
        send_next(i, due);
        summary_.latest_s = std::max(summary_.latest_s, seconds_of_ns(now - due));
      }
    }
  }

  void send_next(std::size_t index, std::int64_t due) {
    Unit& unit = units_[index];
    const PacketBlock::Packet& packet = unit.block->packets.packets[unit.order[unit.next++]];
    const VirtualLivox& control = rack_.device(index);
    if (!packet.imu && control.settings().point_type() != unit.block->points) return;
    const std::span<std::uint8_t> bytes(unit.block->packets.bytes.data() + packet.offset, packet.size);
    stamp(index, bytes);
    if (packet.imu) speed_up_gyro(options_.speed, bytes);
    rack_.send(index, due, packet.imu, bytes);
  }

  void stamp(std::size_t index, std::span<std::uint8_t> bytes) const {
    const Unit& unit = units_[index];
    const VirtualLivox& control = rack_.device(index);
    const DeviceTime& time = control.time();
    const std::int64_t rendered_ns = rendered_stamp_ns(bytes);
    std::int64_t stamp_ns = 0;
    if (time.type() == livox::TimestampType::since_start) {
      const LiveTime live{options_.speed, earlier_s(*unit.block), unit.boot_stamp_ns};
      stamp_ns = std::max<std::int64_t>(0, live.stamp_ns(unit.device.clock, rendered_ns) + rack_.clock_shift_ns(index));
    } else {
      stamp_ns = time.stamp_ns(host_ns(*unit.block, unit.device.clock.true_s(rendered_ns)));
    }
    livox::overwrite_stamp(control.status(), time.type(), stamp_ns, bytes);
  }

  bool is_over(std::int64_t now) {
    const std::int64_t end_ns = *start_ns_ + ns_of_seconds(duration_s_ / options_.speed);
    if (options_.loop || now < end_ns || !ahead_.is_over()) return false;
    for (std::size_t i = 0; i < units_.size(); ++i)
      if (has_next(i)) return false;
    return cameras_.is_idle() || now >= end_ns + last_frames_ns;
  }
  std::int64_t next_ns() {
    std::int64_t next = INT64_MAX;
    for (std::size_t i = 0; start_ns_ && i < units_.size(); ++i)
      next = std::min(next, has_next(i) ? due_ns(units_[i]) : monotonic_now_ns() + render_wait_ns);
    return next;
  }

  const LiveOptions& options_;
  VirtualTable* table_;  ///< Nothing where there is none.
  const TurntableMotion& motion_;
  double duration_s_;
  RenderAhead& ahead_;
  LiveCameras& cameras_;
  VirtualRack& rack_;
  std::vector<Unit> units_;
  std::optional<std::int64_t> start_ns_;
  LiveSummary summary_;
};

// Full seconds of UTC, for devices that follow pulses or PTP.
TimeSourceOptions time_of(TimeSource source) {
  const net::ClockReading clocks = net::read_clocks();
  TimeSourceOptions time;
  time.source = source;
  time.utc_offset_ns = clocks.realtime_ns - clocks.monotonic_ns;
  time.pulse_ns = -time.utc_offset_ns % ns_per_second;
  return time;
}

std::vector<RackDevice> rack_devices(const std::vector<SimDevice>& devices, const Rig& rig,
                                     const Endpoint& broadcast_to, const LiveOptions& options) {
  std::vector<RackDevice> placed;
  const TimeSourceOptions time = time_of(options.time_source);
  for (const SimDevice& device : devices) {
    VirtualLivoxOptions firmware = options.device;
    firmware.identity = device.broadcast;
    firmware.ip = device.point_source.ip;
    firmware.broadcast_to = broadcast_to;
    firmware.time = time;
    firmware.faults = options.control;
    firmware.seed = options.run.seed + placed.size();
    placed.push_back(
        {rig.sensors[static_cast<std::size_t>(device.sensor)].name, firmware, device.point_source, device.imu_source});
  }
  return placed;
}

Error unknown_sensor(const Incident& incident) {
  return input_error("there is no device '" + incident.sensor + "' to which that could happen", "incident",
                     "name a LiDAR of the rig file, or a camera whose driver is aravis; what concerns status words, "
                     "clocks and commands is for LiDARs");
}

bool can_happen_to_camera(const Incident& incident) {
  return incident.kind == Incident::Kind::reboot || incident.kind == Incident::Kind::silence ||
         incident.kind == Incident::Kind::owned_by_other;
}

// Those of the LiDARs; the cameras look for their own.
Expected<std::vector<Incident>> incidents_of_lidars(const Rig& rig, const std::vector<Incident>& incidents) {
  std::vector<Incident> chosen;
  for (const Incident& incident : incidents) {
    const int index = rig.find(incident.sensor);
    if (index < 0) return unknown_sensor(incident);
    const Sensor& sensor = rig.sensors[static_cast<std::size_t>(index)];
    if (sensor.is_lidar()) {
      chosen.push_back(incident);
    } else if (!is_served(sensor) || !can_happen_to_camera(incident)) {
      return unknown_sensor(incident);
    }
  }
  return chosen;
}

}  // namespace

Expected<LiveSummary> serve_live(const Scene& scene, const Rig& rig, const LiveOptions& options,
                                 const RunContext& context) {
  auto devices = make_devices(rig, options.run.seed, options.run.clock_drift_ppm);
  if (!devices) return devices.error();
  auto incidents = incidents_of_lidars(rig, options.incidents);
  if (!incidents) return incidents.error();
  const auto host = host_address(rig);
  if (!host) return host.error();
  const auto simulated = make_simulated_rig(rig, scene.T_scene_table, options.run.turntable, options.run.mount_error,
                                            options.run.seed, options.run.unit_errors);
  if (!simulated) return simulated.error();
  // Whether an inertial unit sends is up to the device's owner.
  for (SimDevice& device : *devices) device.has_imu = livox::facts_of(device.broadcast.type).has_imu;
  auto rack = VirtualRack::open(rack_devices(*devices, rig, broadcast_address(*host, options.discovery_port), options),
                                {*std::move(incidents), options.run.faults, options.run.seed});
  if (!rack) return rack.error();
  const RayCaster caster(scene);
  RenderAhead ahead(caster, scene.materials, *simulated, *devices, options.run.path, options.run.seed, options.loop);
  const auto cameras =
      LiveCameras::start(scene, caster, rig, *simulated, options.run, options.cameras, options.incidents);
  if (!cameras) return cameras.error();
  std::unique_ptr<VirtualTable> table;
  if (!options.table.empty()) {
    VirtualTableOptions wanted;
    wanted.speaks_grbl = options.table_speaks_grbl;
    wanted.link = options.table;
    auto started = VirtualTable::start(wanted);
    if (!started) return started.error();
    table = *std::move(started);
    table->follow(0.0);
  }
  LiveRun run(*devices, simulated->motion.stop_count(), simulated->motion.duration_s(), **rack, ahead, **cameras,
              table.get(), simulated->motion, options);
  return run.run(context);
}

}  // namespace rigcal::sim
