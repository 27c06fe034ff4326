#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace rigcal {

/// Numbers keys 0, 1, 2 .. in the order in which they are first met: open addressing.
class KeyNumbers {
 public:
  struct Met {
    std::uint32_t number = 0;
    bool first = false;
  };
  static constexpr std::uint32_t unknown = ~std::uint32_t{0};

  Met meet(std::uint64_t key) {
    std::size_t at = slot(key);
    if (slots_[at].key == key) return {slots_[at].number, false};
    if (2 * (std::size_t{used_} + 1) > slots_.size()) {
      grow();
      at = slot(key);
    }
    slots_[at] = {key, used_};
    return {used_++, true};
  }
  /// The number of a key, `unknown` where it was never met.
  [[nodiscard]] std::uint32_t find(std::uint64_t key) const {
    const Slot& at = slots_[slot(key)];
    return at.key == key ? at.number : unknown;
  }
  [[nodiscard]] std::uint32_t size() const { return used_; }
  /// Which of 64 shards a key belongs to, by other bits than its place in a table.
  static std::size_t shard(std::uint64_t key) { return static_cast<std::size_t>(mixed(key) >> 58); }
  /// Says that a key will be asked for soon: tables are larger than caches.
  void fetch(std::uint64_t key) const { __builtin_prefetch(&slots_[first_slot(key)]); }
  /// Forgets all keys; the memory stays.
  void clear() {
    std::fill(slots_.begin(), slots_.end(), Slot{});
    used_ = 0;
  }

 private:
  static constexpr std::uint64_t none = ~std::uint64_t{0};
  struct Slot {
    std::uint64_t key = none;
    std::uint32_t number = 0;
  };

  static std::uint64_t mixed(std::uint64_t key) {
    key *= 0x9E3779B97F4A7C15ULL;
    return key ^ key >> 29;
  }
  /// Where a key is looked for first.
  [[nodiscard]] std::size_t first_slot(std::uint64_t key) const {
    return static_cast<std::size_t>(mixed(key) >> 8) & (slots_.size() - 1);
  }
  [[nodiscard]] std::size_t slot(std::uint64_t key) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = first_slot(key);
    while (slots_[at].key != none && slots_[at].key != key) at = (at + 1) & mask;
    return at;
  }
  void grow() {
    std::vector<Slot> slots(2 * slots_.size());
    slots.swap(slots_);
    for (const Slot& each : slots) {
      if (each.key != none) slots_[slot(each.key)] = each;
    }
  }

  std::vector<Slot> slots_ = std::vector<Slot>(1 << 10);
  std::uint32_t used_ = 0;
};

}  // namespace rigcal
