#pragma once

#include <cstdint>
#include <string>

#include "simdata/live/live_run.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace rigcal {

/// What `simulate` takes besides `--live` itself: pace and troubles. `options` must live as long as the command.
void add_live_options(CLI::App& command, CLI::Option& live, sim::LiveOptions& options);

[[nodiscard]] std::string live_summary_text(const sim::LiveSummary& summary);
/// As docs/schema/simulate_live.json has it.
[[nodiscard]] std::string live_summary_json(const std::string& scene, std::uint64_t seed,
                                            const sim::LiveSummary& summary);

}  // namespace rigcal
