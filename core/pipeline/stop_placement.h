#pragma once

#include <optional>
#include <vector>

#include "core/start/rig_start.h"

namespace rigcal {

/// A calibration that has seen some stops, and another one to be laid on them.
struct PlacementInput {
  const Start& solved;                       ///< What is known, and where; the stop stands in it as not known.
  const std::vector<PatchSurfels>& surfels;  ///< Of all patches so far, and of the stop.
  int stop = 0;                              ///< The one to be placed.
  int from = 0;                              ///< A known one near it: the last before it, where there is one.
};

/// Whether a LiDAR that is known saw any surface at the stop.
[[nodiscard]] bool saw_anything(const PlacementInput& input);

/// T_G_base at the stop, good to a few centimetres: turned by `R_from_this` (of the base, as it was told) about the
/// line that the rig has turned about so far, then all that it saw there laid on all that is known. Nothing where too
/// little of it fits.
[[nodiscard]] std::optional<SE3> place_stop(const PlacementInput& input, const Matrix3d& R_from_this);

/// The same where nobody told the turn of a table: it is searched all round the line that the rig has turned about so
/// far. Where more than half of the steps so far are alike, to 6 degrees, one like them is taken unless another fits
/// clearly better; else nothing where another fits nearly as well.
[[nodiscard]] std::optional<SE3> find_stop(const PlacementInput& input);

/// The stops of a table that are not known, each by `find_stop`: next to known ones first, until no more is found.
void find_left_out(const std::vector<PatchSurfels>& surfels, Start& start);

}  // namespace rigcal
