#pragma once

#include <vector>

#include "core/corner/common_planes.h"

namespace rigcal {

/// Fills in PlaneFeature::rays: how what each LiDAR saw of a plane is moved and tilted where its ranges are off. That
/// they bend it, too, counts for nothing, since a seen plane is flat. How dark surfaces are is not known here.
void add_rays(const RigViews& views, std::vector<PlaneFeature>& features);

}  // namespace rigcal
