#pragma once

#include <string>

#include "core/base/run_context.h"
#include "core/io/ground_truth.h"
#include "simdata/packets/run_stream.h"
#include "simdata/rig/light_rig.h"

/// Simulated sessions on disk (docs/manual.md, "simulate"): rig.yaml as given, session.json, ground_truth.yaml, and
/// either lidar.pcapng or patches/, and images of the cameras that have intrinsics. The folder must not exist; it is
/// taken away again where the work fails or is stopped.
namespace rigcal::sim {

/// What was written, for the user.
struct SessionSummary {
  int stops = 0;
  double seconds = 0.0;
  std::uint64_t datagrams = 0;
  std::uint64_t bytes = 0;
  std::uint64_t points = 0;  ///< Of patches.
  std::uint64_t images = 0;
};

/// A session with the packets of a whole run. Errors: what simulate_run and check_cameras refuse, an existing path, the
/// disk.
[[nodiscard]] Expected<SessionSummary> simulate_session(const Scene& scene, const Rig& rig, const RunOptions& options,
                                                        const std::string& path, const RunContext& context);

/// A session with patches and no packets: what every LiDAR saw in every stop, and where asked for an image of each
/// camera. `<path>/patches` is a patch folder.
[[nodiscard]] Expected<SessionSummary> simulate_patches(const Scene& scene, const Rig& rig,
                                                        const LightRigOptions& options, const std::string& path,
                                                        const RunContext& context);

/// The truth of a run as ground_truth.yaml holds it.
[[nodiscard]] GroundTruth ground_truth_of(const Rig& rig, const RunTruth& truth);

}  // namespace rigcal::sim
