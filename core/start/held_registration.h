#pragma once

#include "core/start/registration.h"

namespace rigcal {

/// `refine_registration` with the translation held near zero where surfaces leave it open: its square (m^2) counts as
/// much as `pull` squared distances of surfels.
[[nodiscard]] SE3 refine_held(const SurfelIndex& index, const MovingSurfels& moving, const SE3& X, double from_m,
                              double to_m, double pull);

}  // namespace rigcal
