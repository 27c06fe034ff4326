#include "core/frames/frame_ids.h"

#include "core/clocks/stamps.h"

namespace rigcal {
namespace {

constexpr int believed_contradictions = 3;

}  // namespace

std::int64_t frame_steps(const FrameIdRule& rule, std::uint64_t before, std::uint64_t after) {
  // Nothing counts 64 bits to their end.
  if (rule.bits >= 64) return static_cast<std::int64_t>(after - before);
  const std::uint64_t count = (std::uint64_t{1} << static_cast<unsigned>(rule.bits)) - (rule.skips_zero ? 1 : 0);
  const std::uint64_t steps = (after % count + count - before % count) % count;
  return steps > count / 2 ? -static_cast<std::int64_t>(count - steps) : static_cast<std::int64_t>(steps);
}

bool IdWitness::agrees(std::uint64_t id, std::int64_t pulse) {
  bool believed = true;
  if (last_) {
    const std::int64_t shift =
        stamp_difference(stamp_difference(pulse, last_->pulse), frame_steps(rule_, last_->id, id));
    if (shift != 0) {
      contradictions_ = shift == shift_ ? contradictions_ + 1 : 1;
      shift_ = shift;
      believed = contradictions_ >= believed_contradictions;
    }
  }
  if (!believed) return false;
  last_ = Pair{id, pulse};
  contradictions_ = 0;
  return true;
}

}  // namespace rigcal
