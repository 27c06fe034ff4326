#pragma once

#include <map>
#include <string>

#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/rig/rig.h"

namespace rigcal {

/// Whether images of the format `recorded`, written as PNG, are misread by who goes by the rig file, whose `told` may
/// be empty: a PNG does not tell that it is a mosaic of colours.
[[nodiscard]] bool is_misread(const std::string& recorded, const std::string& told);

/// Gives the rig.yaml of a session or patch folder the formats in which its cameras (by their number in the rig)
/// recorded, with a warning each. Nothing is written where there are none.
Expected<void> name_formats(const std::string& folder, Rig rig, const std::map<int, std::string>& formats,
                            Reporter& reporter);

/// Says in the rig.yaml of a folder whose clouds are written without rings that they have none, with a warning, where
/// `rig` says that they do.
Expected<void> take_back_rings(const std::string& folder, Rig& rig, Reporter& reporter);

}  // namespace rigcal
