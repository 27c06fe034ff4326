#include "core/clocks/leading_clock.h"

#include <algorithm>
#include <cmath>

#include "core/base/seconds.h"

namespace rigcal {
namespace {

/// Session times stay within these, so that sums of them never overflow: some 140 years.
constexpr std::int64_t most_ns = std::int64_t{1} << 62U;
/// A leader is silent that says nothing in so many frames; losses of packets are shorter.
constexpr std::uint64_t silent_frames = 4;
/// How far the frames may be off the stamps: recorders cut them when they get to it.
constexpr std::int64_t frame_slack_ns = ns_per_second;

}  // namespace

std::int64_t LeadingClock::add(int device, std::int64_t device_ns, bool restarts_each_second, std::uint64_t frame) {
  const std::int64_t stamp = std::clamp<std::int64_t>(device_ns, 0, most_ns);
  if (!started_) {
    started_ = true;
    leader_ = device;
    last_device_ns_ = stamp;
    last_frame_ = frame;
    now_ns_ = stamp;
    return now_ns_;
  }
  const std::uint64_t frames = frame > last_frame_ ? std::min<std::uint64_t>(frame - last_frame_, 1'000'000) : 0;
  const std::int64_t by_frames = static_cast<std::int64_t>(frames) * frame_ns_;
  if (device != leader_) {
    if (frames < silent_frames) return now_ns_;
    leader_ = device;
    now_ns_ = std::min(now_ns_ + by_frames, most_ns);
  } else {
    std::int64_t step = stamp - last_device_ns_;
    if (restarts_each_second) {
      step += ns_per_second * std::lround(static_cast<double>(by_frames - step) / static_cast<double>(ns_per_second));
    }
    const bool late = step < 0 && step > -frame_slack_ns;  // packets that overtook each other, or a clock that was set
    if (late && frames < silent_frames) return now_ns_;
    if (step < 0 || step > by_frames + frame_slack_ns) step = by_frames;
    now_ns_ = std::min(now_ns_ + step, most_ns);
  }
  last_device_ns_ = stamp;
  last_frame_ = frame;
  return now_ns_;
}

}  // namespace rigcal
