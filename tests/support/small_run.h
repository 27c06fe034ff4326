#pragma once

#include <filesystem>
#include <string>

#include "simdata/session/session_writer.h"

namespace rigcal {

/// An AVIA (the base) and a MID-40 on a turntable by hand. `more_sensors` and `more_extrinsics` are lines of YAML under
/// `sensors:` and `initial_extrinsics:`, indented by two.
[[nodiscard]] std::string small_rig(const std::string& more_sensors = {}, const std::string& more_extrinsics = {});

/// The lines of a camera of 640 x 512 pixels under `sensors:`.
[[nodiscard]] std::string small_camera(const std::string& name, const std::string& pixel_format);

/// A table that hurries and hardly swings keeps recordings short: what the stops hold is what matters.
[[nodiscard]] sim::RunOptions hurried_run(int stops, double dwell_s);

/// A session of the courtyard; `rig_yaml` is that of a rig file. The test links simdata_session.
void simulate_courtyard(const std::string& rig_yaml, const sim::RunOptions& run, const std::filesystem::path& session);

}  // namespace rigcal
