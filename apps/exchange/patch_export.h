#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "apps/exchange/image_files.h"
#include "apps/recording/stop_reader.h"

namespace rigcal {

enum class PatchLayout {
  patches,  ///< A patch folder (docs/manual.md, "Inputs") with images, rig.yaml and trajectory.tum.
  pcd,      ///< <sensor>_<stop>.pcd side by side, with the time of each point where it is known.
  las,      ///< <sensor>_<stop>.las side by side.
};

struct PatchExport {
  StopReading reading;
  std::uint64_t files = 0;   ///< Of clouds.
  std::uint64_t images = 0;  ///< In the patch folder.
};

/// T_G_base of the stops as the gyro tells it: rotations chained, translations zero, up to the first stop to which the
/// rotation is not known. Empty where no turn is known: there is one stop, or the inertial unit sits in another sensor
/// than the base and the rig file does not say how that is mounted.
[[nodiscard]] std::map<int, SE3> gyro_trajectory(const Rig& rig, const std::vector<StopRecord>& stops);

/// Writes the points of a recording's stops, in the sensors' own frames; patches and pcd as float metres exactly as
/// decoded, las to a tenth of a millimetre. A source of patches gives its points within the LiDARs' ranges, without
/// times, and its trajectory. A patch folder also gets the images of the stops, unless `images` takes all that a bag
/// has. The folder appears as a whole at the end; an existing path is never touched. The points go straight to the
/// disk: memory does not grow with a stop's length. Errors: those of `read_stops` and `reading_error`, of
/// `list_patch_folder`, `read_pcd` and `write_patch_images`, the disk.
[[nodiscard]] Expected<PatchExport> export_patches(const StreamSource& source, PatchLayout layout,
                                                   const std::string& out, const RunContext& context,
                                                   ImageFiles* images = nullptr);

}  // namespace rigcal
