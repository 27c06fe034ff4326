#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "simdata/packets/packet_renderer.h"

namespace rigcal::sim {

/// Packets of one device and one block of time, rendered.
struct LiveBlock {
  std::int64_t number = 0;  ///< Counts on over the repetitions of a run.
  livox::DataType points = livox::DataType::cartesian;
  PacketBlock packets;
};

/// Renders the packets of a run some tenths of a second before they are due, in a thread of its own. Devices may be
/// told meanwhile to send another data type; what is rendered already is of the old one.
class RenderAhead {
 public:
  /// What is passed by reference must outlive this. `repeat`: the run begins again when it is over.
  RenderAhead(const RayCaster& caster, const std::vector<Material>& materials, const SimulatedRig& rig,
              std::vector<SimDevice> devices, const PacketPath& path, std::uint64_t seed, bool repeat);
  ~RenderAhead();
  RenderAhead(const RenderAhead&) = delete;
  RenderAhead& operator=(const RenderAhead&) = delete;

  /// The next block of a device, or nothing where it is not rendered yet or the run is over.
  [[nodiscard]] std::unique_ptr<LiveBlock> take(std::size_t device);
  /// Whether all blocks of the run were taken.
  [[nodiscard]] bool is_over() const;
  void set_points(std::size_t device, livox::DataType points, bool nearest_only);

  [[nodiscard]] std::int64_t blocks_of_a_run() const { return blocks_of_a_run_; }

 private:
  struct Wish {
    livox::DataType points = livox::DataType::cartesian;
    bool nearest_only = false;
    bool operator==(const Wish&) const = default;
  };
  struct Unit {
    SimDevice device;
    Wish made;  ///< What the renderer was made for.
    std::unique_ptr<PacketRenderer> renderer;
  };

  void run();
  void render(std::int64_t first, std::int64_t count, const std::vector<Wish>& wishes);

  const RayCaster& caster_;
  const std::vector<Material>& materials_;
  const SimulatedRig& rig_;
  PacketPath path_;
  std::uint64_t seed_;
  bool repeat_;
  std::int64_t blocks_of_a_run_;
  std::vector<std::unique_ptr<Unit>> units_;  ///< Of the rendering thread.

  mutable std::mutex mutex_;
  std::condition_variable wanted_;
  std::vector<std::deque<std::unique_ptr<LiveBlock>>> ready_;
  std::vector<Wish> wishes_;
  std::int64_t next_ = 0;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace rigcal::sim
