#include "core/voxel/ray_table.h"

#include <algorithm>
#include <utility>

#include "core/base/radix_sort.h"

namespace rigcal {
namespace {

// So many wait at most, 8 MB with their order: all of most patches.
constexpr std::size_t most_waiting = 1 << 18;

}  // namespace

void RayTable::begin(const CellOptions& options) {
  options_ = options;
  grid_ = RayGrid(options.max_range_m, options.size_m);
  waiting_.clear();
  order_.clear();
  kept_.clear();
}

void RayTable::add(const PointBlock& block) {
  if (waiting_.size() + block.count > most_waiting) keep_sums();
  grid_.place(block, placed_);
  const double border_m = border_share * options_.size_m;
  for (std::size_t i = 0; i < block.count; ++i) {
    const auto number = static_cast<std::uint32_t>(waiting_.size());
    order_.push_back({placed_.key[i], number, Part::inside, 0});
    const bool may_be = grid_.is_at_change(placed_.deep[i]);
    if (const auto other = may_be ? grid_.other_side(placed_, i, border_m) : std::nullopt) {
      has_other_sides_ = true;
      order_.push_back({other->place.key, number, other->is_nearer ? Part::behind_far : Part::before_near,
                        static_cast<std::uint8_t>(other->place.sixteenth)});
    }
    waiting_.push_back({static_cast<float>(placed_.depth[i]), static_cast<float>(placed_.left[i]),
                        static_cast<float>(placed_.up[i]), static_cast<std::uint8_t>(placed_.sixteenth[i]),
                        block.point[i]->reflectivity, true});
  }
}

// Sums up the kept and the waiting ones of each cell in the parts that `next` gives, and has `take` take them by their
// key.
template <class Next, class Take>
void RayTable::for_each_cell(const Next& next, const Take& take) {
  constexpr std::size_t soon = 16;
  const double border = (0.5 - border_share) * options_.size_m;
  radix_sort(order_);
  if (std::exchange(has_other_sides_, false)) let_lone_ones_be();
  std::size_t kept = 0;
  std::size_t i = 0;
  while (kept < kept_.size() || i < order_.size()) {
    std::uint64_t key = ~std::uint64_t{0};
    if (kept < kept_.size()) key = kept_[kept].key;
    if (i < order_.size()) key = std::min(key, order_[i].key);
    const Vector3d middle = grid_.middle_ahead(key);
    CellParts& parts = next();
    for (; kept < kept_.size() && kept_[kept].key == key; ++kept) {
      const KeptSums& from = kept_[kept];
      if (from.sums.n > 0.0) parts.of(from.sixteenth) = from.sums;
      parts.at_near[from.sixteenth] = from.at_near;
      parts.at_far[from.sixteenth] = from.at_far;
      parts.dark[from.sixteenth] = from.dark;
    }
    for (; i < order_.size() && order_[i].key == key; ++i) {
      if (i + soon < order_.size()) __builtin_prefetch(&waiting_[order_[i + soon].number]);
      if (order_[i].part != Part::inside) {
        (order_[i].part == Part::behind_far ? parts.at_far : parts.at_near)[order_[i].sixteenth] += 1.0;
        continue;
      }
      const WaitingPoint& point = waiting_[order_[i].number];
      const double ahead = point.depth - middle.x();
      parts.of(point.sixteenth).add(ahead, point.left - middle.y(), point.up - middle.z());
      parts.at_near[point.sixteenth] += point.counts_at_border && ahead < -border ? 1.0 : 0.0;
      parts.at_far[point.sixteenth] += point.counts_at_border && ahead > border ? 1.0 : 0.0;
      parts.dark[point.sixteenth] += darkness_of(point.reflectivity);
    }
    take(key);
  }
  waiting_.clear();
  order_.clear();
}

// A point counts on both sides of a border or on none: not where there is nothing on the other side.
void RayTable::let_lone_ones_be() {
  std::size_t kept = 0;
  for (std::size_t begin = 0, end = 0; begin < order_.size(); begin = end) {
    const std::uint64_t key = order_[begin].key;
    bool is_lone = true;
    for (end = begin; end < order_.size() && order_[end].key == key; ++end) is_lone &= order_[end].part != Part::inside;
    if (!is_lone) continue;
    while (kept < kept_.size() && kept_[kept].key < key) ++kept;
    for (std::size_t k = kept; k < kept_.size() && kept_[k].key == key; ++k) is_lone &= kept_[k].sums.n == 0.0;
    if (!is_lone) continue;
    for (std::size_t i = begin; i < end; ++i) waiting_[order_[i].number].counts_at_border = false;
  }
}

void RayTable::keep_sums() {
  std::vector<KeptSums> all;
  CellParts parts;
  const auto next = [&]() -> CellParts& {
    parts.clear();
    return parts;
  };
  for_each_cell(next, [&](std::uint64_t key) {
    for (std::uint32_t k = 0; k < cell_sixteenths; ++k) {
      const bool is_hit = (parts.hit >> k & 1U) != 0;
      if (!is_hit && parts.at_near[k] == 0.0 && parts.at_far[k] == 0.0) continue;
      all.push_back({key, k, parts.at_near[k], parts.at_far[k], parts.dark[k], is_hit ? parts.sums[k] : CellSums{}});
    }
  });
  kept_ = std::move(all);
}

void RayTable::finish(PatchCells& out) {
  pieces_.begin(grid_);
  const auto next = [this]() -> CellParts& { return pieces_.next(); };
  for_each_cell(next, [this](std::uint64_t key) { pieces_.take(key); });
  // Copied, so that what is given away has its size, and what it grew in is used again.
  out.pieces = pieces_.finish();
  begin(options_);
}

}  // namespace rigcal
