#pragma once

#include <cstdint>
#include <string>

#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/io/ground_truth.h"
#include "core/io/patch_folder.h"
#include "core/rig/rig.h"
#include "simdata/rig/sim_rig.h"
#include "simdata/scene/scene.h"

/// Images of a simulated run on disk: of every camera of the rig that has intrinsics.
namespace rigcal::sim {

/// Refuses a rig one of whose cameras cannot be simulated: a pixel format that is not known.
[[nodiscard]] Expected<void> check_cameras(const Rig& rig);

/// Where a run lies in session time.
struct RunTimes {
  std::int64_t start_ns = 0;     ///< Of the session,
  std::int64_t sampling_ns = 0;  ///< and of the motion's time 0.
};

/// Writes images/<camera>/NNNNNN.png and frames.csv, and trigger.csv where a camera has a trigger: `per_stop` pulses in
/// every stop once it has settled, each of which all cameras follow. A camera without a trigger exposes at the same
/// times, but without a pulse's number. Exposures see the rig where it really is in their middle. Adds the cameras'
/// clocks to `truth`. The count of images.
[[nodiscard]] Expected<std::uint64_t> write_session_images(const Scene& scene, const Rig& rig,
                                                           const SimulatedRig& simulated, std::uint64_t seed,
                                                           const RunTimes& times, int per_stop,
                                                           const std::string& session, const RunContext& context,
                                                           GroundTruth& truth);

/// Writes image/<camera>/<stop>.png into a patch folder: one image in the middle of every stop (of each part of a
/// bumped one), where the patches are on average.
[[nodiscard]] Expected<std::uint64_t> write_patch_images(const Scene& scene, const Rig& rig,
                                                         const SimulatedRig& simulated, std::uint64_t seed,
                                                         const PatchFolderWriter& folder, const RunContext& context);

}  // namespace rigcal::sim
