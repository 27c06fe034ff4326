#pragma once

#include <vector>

#include "core/corner/fitted_plane.h"
#include "core/voxel/cells.h"

namespace rigcal {

/// Planes for which the surfels of a cloud vote, roughly, one after the other; those with most surfels first.
struct PlaneVotes {
  std::vector<FittedPlane> planes;  ///< `sigma_m` is that of the surfels' points.
  double surfel_m = 0.5;            ///< Size at which the cloud shows its surfaces.
};
/// At most `most` planes, in the frame of the cells; fewer where no more have votes.
[[nodiscard]] PlaneVotes vote_for_planes(const PatchCells& cells, std::size_t most);

}  // namespace rigcal
