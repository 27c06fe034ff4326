#pragma once

#include "simdata/rig/turntable_motion.h"

namespace CLI {
class App;
}

namespace rigcal {

/// Adds what `simulate` takes about the motion to a command: stops, dwell, and what troubles them. Angles in degrees
/// there. `options` must live as long as the command.
void add_motion_options(CLI::App& command, sim::TurntableOptions& options);
/// What only all of them together show, once they are parsed: throws CLI::ValidationError. `with_ends`: the still time
/// before and after the run is simulated, too.
void check_motion(const CLI::App& command, const sim::TurntableOptions& options, bool with_ends);

}  // namespace rigcal
