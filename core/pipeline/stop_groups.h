#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/voxel/plane_map.h"

namespace rigcal {

/// Stops that hang together by planes which several of them saw: in each group by planes of at least two directions, so
/// that their turns are held, too. A floor alone, that every stop sees however it is turned, holds none; nor do the few
/// planes that fall together by chance where groups stand in wrong places, which is why a share of what either saw is
/// asked for. The largest group first (of equal ones the earlier), stops in ascending order. `told[j]`: something else
/// than planes (a gyro, a trajectory) tells how stop j stands to the one before. Of `used` stops only; where nothing
/// holds any turn, all are one group, since then planes tell nothing about groups.
[[nodiscard]] std::vector<std::vector<std::size_t>> stop_groups(const std::vector<char>& used,
                                                                const std::vector<char>& told, const PlaneMap& map);

/// Why stops of these numbers, ascending, are left out: they are such a group, and not the largest.
[[nodiscard]] std::string apart_words(const std::vector<int>& numbers);

}  // namespace rigcal
