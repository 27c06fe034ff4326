#include "simdata/packets/run_stream.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/seconds.h"

namespace rigcal::sim {
namespace {

constexpr double broadcast_s = 2.0;         // before sampling
constexpr std::int64_t blocks_a_turn = 16;  // rendered at once, 0.4 s: memory stays small, both cores stay busy

struct Waiting {
  std::int64_t stamp_ns = 0;
  std::size_t device = 0;
  Endpoint from;
  Endpoint to;
  std::vector<std::uint8_t> bytes;
};

// Puts the packets of all devices into the order in which the host saw them.
class Merger {
 public:
  Merger(const RunTruth& truth, const DatagramSink& sink)
      : truth_(truth), sink_(sink), last_stamp_(truth.devices.size(), 0) {}

  void add(std::size_t device, const PacketBlock& block) {
    const SimDevice& sender = truth_.devices[device];
    std::vector<PacketBlock::Packet> packets = block.packets;
    std::stable_sort(packets.begin(), packets.end(), [](const auto& a, const auto& b) { return a.sent_s < b.sent_s; });
    for (const PacketBlock::Packet& packet : packets) {
      // A device's packets go one way and do not overtake each other.
      std::int64_t& last = last_stamp_[device];
      last = std::max<std::int64_t>(truth_.sampling_ns + ns_of_seconds(packet.sent_s + packet.delay_s), last + 1000);
      const auto begin = block.bytes.begin() + static_cast<std::ptrdiff_t>(packet.offset);
      waiting_.push_back({last, device, packet.imu ? sender.imu_source : sender.point_source, sender.data_sink,
                          std::vector<std::uint8_t>(begin, begin + static_cast<std::ptrdiff_t>(packet.size))});
    }
  }

  void add(std::size_t device, std::int64_t stamp_ns, const Endpoint& from, const Endpoint& to,
           std::vector<std::uint8_t> bytes) {
    waiting_.push_back({stamp_ns, device, from, to, std::move(bytes)});
  }

  // Hands on all that was seen before `until_ns`; whatever comes later is later.
  Expected<void> flush(std::int64_t until_ns) {
    std::stable_sort(waiting_.begin(), waiting_.end(), [](const Waiting& a, const Waiting& b) {
      return a.stamp_ns != b.stamp_ns ? a.stamp_ns < b.stamp_ns : a.device < b.device;
    });
    std::size_t done = 0;
    for (; done < waiting_.size() && waiting_[done].stamp_ns < until_ns; ++done) {
      const Waiting& next = waiting_[done];
      const auto taken = sink_({next.stamp_ns, next.from, next.to, next.bytes});
      if (!taken) return taken.error();
    }
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(done));
    return {};
  }

 private:
  const RunTruth& truth_;
  const DatagramSink& sink_;
  std::vector<Waiting> waiting_;
  std::vector<std::int64_t> last_stamp_;
};

RunTruth truth_of(const SimulatedRig& simulated, std::vector<SimDevice> devices, const RunOptions& options) {
  RunTruth truth;
  truth.start_ns = options.start_ns;
  truth.sampling_ns = options.start_ns + ns_of_seconds(broadcast_s);
  truth.T_base_sensor = simulated.T_base_sensor;
  truth.axis = simulated.motion.axis_in_base();
  truth.axis_point = simulated.motion.axis_point_in_base();
  const std::vector<Rest> rests = simulated.motion.rests();
  const auto settled = [&](const Rest& rest) {
    return simulated.motion.T_scene_base_settled(0.5 * (rest.start_s + rest.end_s));
  };
  const SE3 T_G_scene = settled(rests.front()).inverse();
  for (const Rest& rest : rests) {
    truth.stops.push_back({static_cast<int>(truth.stops.size()), truth.sampling_ns + ns_of_seconds(rest.start_s),
                           truth.sampling_ns + ns_of_seconds(rest.end_s)});
    truth.T_G_base.push_back(T_G_scene * settled(rest));
  }
  truth.end_ns = truth.sampling_ns + ns_of_seconds(simulated.motion.duration_s());
  for (const SimDevice& device : devices)
    truth.imu_errors.push_back(device.has_imu ? draw_imu_errors(options.seed, device.sensor) : ImuErrors{});
  truth.devices = std::move(devices);
  truth.lidars = simulated.lidars;
  return truth;
}

void add_broadcasts(const RunTruth& truth, Merger& merger) {
  for (std::size_t i = 0; i < truth.devices.size(); ++i) {
    const SimDevice& device = truth.devices[i];
    const Endpoint from{device.point_source.ip, livox::kDevicePort};
    const Endpoint to = broadcast_address(device.data_sink.ip);
    for (int second = 0; second < static_cast<int>(broadcast_s); ++second) {
      const std::int64_t stamp =
          truth.start_ns + second * ns_per_second + static_cast<std::int64_t>(i) * 137'000'000LL % ns_per_second;
      merger.add(i, stamp, from, to, livox::make_broadcast(device.broadcast, static_cast<std::uint16_t>(second)));
    }
  }
}

}  // namespace

Expected<RunTruth> simulate_run(const Scene& scene, const Rig& rig, const RunOptions& options, const DatagramSink& sink,
                                const RunContext& context) {
  auto devices = make_devices(rig, options.seed, options.clock_drift_ppm);
  if (!devices) return devices.error();
  const auto simulated = make_simulated_rig(rig, scene.T_scene_table, options.turntable, options.mount_error,
                                            options.seed, options.unit_errors);
  if (!simulated) return simulated.error();
  RunTruth truth = truth_of(*simulated, *std::move(devices), options);
  const RayCaster caster(scene);
  std::vector<PacketRenderer> renderers;
  for (std::size_t i = 0; i < truth.devices.size(); ++i)
    renderers.emplace_back(caster, scene.materials, *simulated, simulated->lidars[i], truth.devices[i], options.path,
                           options.seed);

  PacketFaults faults(options.faults, options.seed, sink);
  const DatagramSink through_faults = [&faults](const Datagram& datagram) { return faults.add(datagram); };
  Merger merger(truth, through_faults);
  add_broadcasts(truth, merger);
  const double duration_s = simulated->motion.duration_s();
  const auto blocks = static_cast<std::int64_t>(std::ceil(duration_s / PacketRenderer::block_s));
  for (std::int64_t first = 0; first < blocks; first += blocks_a_turn) {
    if (context.cancelled()) return cancelled_error();
    const auto count = static_cast<std::size_t>(std::min(blocks_a_turn, blocks - first));
    std::vector<PacketBlock> rendered(count * renderers.size());
    parallel_for(rendered.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        rendered[i] = renderers[i % renderers.size()].render(first + static_cast<std::int64_t>(i / renderers.size()));
    });
    for (std::size_t i = 0; i < rendered.size(); ++i) merger.add(i % renderers.size(), rendered[i]);
    const double done_s = std::min(static_cast<double>(first + blocks_a_turn) * PacketRenderer::block_s, duration_s);
    const auto flushed = merger.flush(truth.sampling_ns + ns_of_seconds(done_s));
    if (!flushed) return flushed.error();
    context.reporter.progress("simulate", done_s / duration_s);
  }
  if (const auto flushed = merger.flush(INT64_MAX); !flushed) return flushed.error();
  if (const auto flushed = faults.flush(); !flushed) return flushed.error();
  const auto counts_of = [&faults](const Endpoint& from) {
    const auto found = faults.counts().find(from);
    return found == faults.counts().end() ? FaultCounts{} : found->second;
  };
  for (const SimDevice& device : truth.devices) {
    truth.point_packets.push_back(counts_of(device.point_source));
    truth.imu_packets.push_back(counts_of(device.imu_source));
  }
  return truth;
}

}  // namespace rigcal::sim
