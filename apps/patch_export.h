#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "apps/image_files.h"
#include "apps/stop_reader.h"

namespace rigcal {

enum class PatchLayout {
  patches,  ///< A patch folder (contract section 4) with rig.yaml and trajectory.tum.
  pcd,      ///< <sensor>_<stop>.pcd side by side, with the time of each point where it is known.
  las,      ///< <sensor>_<stop>.las side by side.
};

struct PatchExport {
  StopReading reading;
  std::uint64_t files = 0;
};

/// T_G_base of the stops as the gyro tells it: rotations chained, translations zero, up to the first stop to which the
/// rotation is not known. Empty where the inertial unit sits in another sensor than the base and the rig file does not
/// say how that is mounted.
[[nodiscard]] std::map<int, SE3> gyro_trajectory(const Rig& rig, const std::vector<StopRecord>& stops);

/// Writes the points of a recording's stops, in the sensors' own frames; patches and pcd as float metres exactly as
/// decoded, las to a tenth of a millimetre. A source of patches gives its points within the LiDARs' ranges, without
/// times, and its trajectory. `images`: where images go that the recording has, if they are wanted; not those of
/// patches. The folder appears as a whole at the end; an existing path is never touched. The points go straight to the
/// disk: memory does not grow with a stop's length. Errors: those of `read_stops` and `reading_error`, of
/// `list_patch_folder` and `read_pcd`, the disk.
[[nodiscard]] Expected<PatchExport> export_patches(const StreamSource& source, PatchLayout layout,
                                                   const std::string& out, const RunContext& context,
                                                   ImageFiles* images = nullptr);

}  // namespace rigcal
