#pragma once

#include <cstdint>
#include <optional>

namespace rigcal::trigger {

/// Tells the rising edges among a PPS device's answers: it answers to falling ones, too, with the last that rose.
class PpsCount {
 public:
  /// `sequence`: of the last edge that rose before it was listened to.
  explicit PpsCount(std::uint32_t sequence) : last_(sequence) {}

  /// How many edges were missed since the last one that was seen; nothing where this is no other edge.
  [[nodiscard]] std::optional<std::uint32_t> missed_before(std::uint32_t sequence) {
    if (sequence == last_) return std::nullopt;
    const std::uint32_t steps = sequence - last_;
    // Back is no step: then the source counts anew.
    const bool is_on = steps < 0x8000'0000U;
    const std::uint32_t missed = has_seen_ && is_on ? steps - 1 : 0;
    last_ = sequence;
    has_seen_ = true;
    return missed;
  }

 private:
  std::uint32_t last_;
  bool has_seen_ = false;
};

}  // namespace rigcal::trigger
