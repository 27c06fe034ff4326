#pragma once

#include "simdata/rig/turntable_motion.h"

namespace CLI {
class App;
}

namespace rigcal {

/// Adds what `simulate` takes about the motion to a command: stops, dwell, and what troubles them. Angles in degrees
/// there. `options` must live as long as the command.
void add_motion_options(CLI::App& command, sim::TurntableOptions& options);

}  // namespace rigcal
