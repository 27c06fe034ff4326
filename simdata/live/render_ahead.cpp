#include "simdata/live/render_ahead.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"

namespace rigcal::sim {
namespace {

constexpr std::size_t blocks_ahead = 20;  // Half a second.
constexpr std::int64_t blocks_at_once = 4;

}  // namespace

RenderAhead::RenderAhead(const RayCaster& caster, const std::vector<Material>& materials, const SimulatedRig& rig,
                         std::vector<SimDevice> devices, const PacketPath& path, std::uint64_t seed, bool repeat)
    : caster_(caster),
      materials_(materials),
      rig_(rig),
      path_(path),
      seed_(seed),
      repeat_(repeat),
      blocks_of_a_run_(static_cast<std::int64_t>(std::ceil(rig.motion.duration_s() / PacketRenderer::block_s))),
      ready_(devices.size()) {
  for (SimDevice& device : devices) {
    wishes_.push_back({device.points, device.nearest_only});
    units_.push_back(std::make_unique<Unit>());
    units_.back()->device = std::move(device);
  }
  thread_ = std::thread([this] { run(); });
}

RenderAhead::~RenderAhead() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wanted_.notify_all();
  thread_.join();
}

void RenderAhead::run() {
  while (true) {
    std::int64_t first = 0;
    std::vector<Wish> wishes;
    {
      std::unique_lock lock(mutex_);
      wanted_.wait(lock, [this] {
        return stop_ ||
               std::all_of(ready_.begin(), ready_.end(), [](const auto& queue) { return queue.size() < blocks_ahead; });
      });
      if (stop_ || (!repeat_ && next_ >= blocks_of_a_run_)) return;
      first = next_;
      wishes = wishes_;
    }
    const std::int64_t left = blocks_of_a_run_ - first % blocks_of_a_run_;
    render(first, std::min(left, blocks_at_once), wishes);
  }
}

void RenderAhead::render(std::int64_t first, std::int64_t count, const std::vector<Wish>& wishes) {
  for (std::size_t i = 0; i < units_.size(); ++i) {
    Unit& unit = *units_[i];
    if (unit.renderer && unit.made == wishes[i]) continue;
    set_data_type(unit.device, wishes[i].points);
    unit.device.nearest_only = wishes[i].nearest_only;
    unit.made = wishes[i];
    unit.renderer =
        std::make_unique<PacketRenderer>(caster_, materials_, rig_, rig_.lidars[i], unit.device, path_, seed_);
  }
  std::vector<std::unique_ptr<LiveBlock>> blocks(static_cast<std::size_t>(count) * units_.size());
  parallel_for(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t device = k % units_.size();
      const std::int64_t number = first + static_cast<std::int64_t>(k / units_.size());
      blocks[k] = std::make_unique<LiveBlock>(
          LiveBlock{number, wishes[device].points, units_[device]->renderer->render(number % blocks_of_a_run_)});
    }
  });
  const std::lock_guard lock(mutex_);
  for (std::size_t k = 0; k < blocks.size(); ++k) ready_[k % units_.size()].push_back(std::move(blocks[k]));
  next_ = first + count;
}

std::unique_ptr<LiveBlock> RenderAhead::take(std::size_t device) {
  std::unique_ptr<LiveBlock> block;
  {
    const std::lock_guard lock(mutex_);
    auto& queue = ready_[device];
    if (queue.empty()) return block;
    block = std::move(queue.front());
    queue.pop_front();
  }
  wanted_.notify_one();
  return block;
}

bool RenderAhead::is_over() const {
  const std::lock_guard lock(mutex_);
  return !repeat_ && next_ >= blocks_of_a_run_ &&
         std::all_of(ready_.begin(), ready_.end(), [](const auto& queue) { return queue.empty(); });
}

void RenderAhead::set_points(std::size_t device, livox::DataType points, bool nearest_only) {
  const std::lock_guard lock(mutex_);
  wishes_[device] = {points, nearest_only};
}

}  // namespace rigcal::sim
