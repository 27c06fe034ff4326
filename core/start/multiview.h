#pragma once

#include <cstddef>
#include <vector>

#include "core/planes/adjust.h"
#include "core/start/surfels.h"

namespace rigcal {

struct MultiviewOptions {
  double from_m = 0.3;   ///< Tolerance of the first association, of the plane distance; it shrinks ...
  double to_m = 0.06;    ///< ... to this.
  AdjustOptions priors;  ///< Only the priors of these options are used.
};

/// How many pairs of surfels are summed up at a time. Each such sum has a matrix of all unknowns, and all of them are
/// there at once: where they would take more than half a gigabyte they are fewer, down to four, by the data's size
/// alone.
[[nodiscard]] std::size_t pairs_at_a_time(std::size_t pairs, std::size_t unknowns);

/// Lays all surfels of all patches on each other at once (point to plane, both ways), by moving the free blocks of
/// `layout`. For a start that is right to about `from_m`; leaves the state good to a centimetre or better.
void align_surfels(const std::vector<PatchSurfels>& patches, const ParameterLayout& layout,
                   const MultiviewOptions& options, RigState& state);

}  // namespace rigcal
