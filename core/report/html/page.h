#pragma once

#include <string>

#include "core/quality/result.h"
#include "core/rig/rig.h"

namespace rigcal {

/// report.html: one page that a person can judge a result by, status first. It holds all that it needs (pictures,
/// style, the 3-D view) and may load nothing: its own policy forbids it. The same result gives the same bytes. `rig`
/// (or null) tells what kind of sensors they are, and what they see. About 1 MB, and up to 4 MB of points, 3 MB of
/// pictures of the map and the overlays.
[[nodiscard]] std::string report_html(const CalibrationResult& result, const Rig* rig);

}  // namespace rigcal
