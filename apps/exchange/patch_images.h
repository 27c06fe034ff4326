#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "apps/recording/stop_reader.h"
#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/io/patch_folder.h"

namespace rigcal {

struct PatchImages {
  std::uint64_t files = 0;
  /// Where images are of a Bayer mosaic and the rig file does not say so: the pixel_format that they want, by sensor.
  std::map<int, std::string> missing_formats;
};

/// Writes of each camera what `calibrate` takes of the recording: one image a stop, the mean where there are several,
/// without loss. `stops`: those that clouds were written of. Of which cameras there is nothing, and what was left out,
/// goes to the reporter. Errors: the disk, cancelled.
[[nodiscard]] Expected<PatchImages> write_patch_images(const StreamSource& source, const std::vector<StopRecord>& stops,
                                                       const PatchFolderWriter& folder, const RunContext& context);

}  // namespace rigcal
