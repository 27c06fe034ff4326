#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "core/start/rig_start.h"

namespace rigcal {

/// In which order LiDARs were placed, and from which places in it on all rests on one of which nobody was sure.
struct Doubts {
  std::vector<int> order;
  std::vector<std::size_t> from;
};

/// Finds the LiDARs without a guess, and those that fit nowhere near theirs, once the rig's poses are known: each finds
/// the axis that it was carried round by itself, or where the rig drove its mounting (`find_mountings`), and then
/// stands where it meets what the LiDARs found so far have seen. Those that are sure come first and help the others.
/// Sets `matches`, `lidar_known` and the extrinsics.
[[nodiscard]] Doubts place_without_guess(const StartInput& input, const std::vector<PatchSurfels>& patches,
                                         Start& start);

/// What was laid on something doubtful is no surer than that, but tells more about it: all that came from the doubtful
/// one on is laid, as one, on what was known before, here and where it fits next best, and everything is aligned with
/// it (`align`). The place that then fits better is taken; how well the other one fits is the runner-up of their
/// matches.
void reconsider(const Doubts& doubts, const std::vector<PatchSurfels>& patches,
                const std::function<void(Start&)>& align, Start& start);

}  // namespace rigcal
