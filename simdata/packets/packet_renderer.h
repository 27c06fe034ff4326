#pragma once

#include <cstdint>
#include <vector>

#include "simdata/lidar/shot_meter.h"
#include "simdata/packets/sim_device.h"
#include "simdata/rig/imu_model.h"
#include "simdata/rig/sim_rig.h"

namespace rigcal::sim {

/// Packets of one device, in the order in which it sent them.
struct PacketBlock {
  struct Packet {
    double sent_s = 0.0;   ///< True time of its last shot or reading.
    double delay_s = 0.0;  ///< Until the host stamps it.
    std::size_t offset = 0;
    std::size_t size = 0;
    bool imu = false;
  };
  std::vector<Packet> packets;
  std::vector<std::uint8_t> bytes;
};

/// How packets reach the host: the delay is at least `least_delay_s` and on average `jitter_s` more.
struct PacketPath {
  double least_delay_s = 0.2e-3;
  double jitter_s = 0.05e-3;
};

/// The errors of the inertial unit of a sensor in the run of that seed.
[[nodiscard]] ImuErrors draw_imu_errors(std::uint64_t seed, int sensor);

/// Renders what one device sends in blocks of time. Every block has its own random stream, so blocks may be rendered in
/// any order and by any thread.
class PacketRenderer {
 public:
  /// All that is passed by reference must outlive the renderer.
  PacketRenderer(const RayCaster& caster, const std::vector<Material>& materials, const SimulatedRig& rig,
                 const SimulatedLidar& lidar, const SimDevice& device, const PacketPath& path, std::uint64_t seed);

  /// The packets whose first shot or reading falls into block `index`: true times from index * block_s on.
  [[nodiscard]] PacketBlock render(std::int64_t index) const;

  static constexpr double block_s = 0.025;

 private:
  struct Interval {
    double start_s = 0.0;
    double end_s = 0.0;
  };
  void render_points(const Interval& block, Random& random, PacketBlock& out) const;
  void fill_packet(std::int64_t number, double start_s, double end_s, Random& random, std::vector<Point>& points,
                   std::vector<Vector3d>& directions) const;
  void render_imu(const Interval& block, Random& random, PacketBlock& out) const;
  void append(const std::vector<std::uint8_t>& packet, double sent_s, bool imu, Random& random, PacketBlock& out) const;

  const RayCaster& caster_;
  const SimulatedRig& rig_;
  const SimulatedLidar& lidar_;
  const SimDevice& device_;
  PacketPath path_;
  std::uint64_t seed_;
  ShotMeter meter_;
  ImuModel imu_;
};

}  // namespace rigcal::sim
