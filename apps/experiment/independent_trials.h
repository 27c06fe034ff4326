#pragma once

#include <functional>
#include <string>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

/// Calls `trial(k)` for k = 0 .. count - 1, as many at a time as there may be threads, and tells of the progress under
/// `name`. What a trial finds it keeps in a place of its own, so that nothing depends on who ran first. Errors: the
/// first trial's, in their order, that has one; cancelled.
[[nodiscard]] Expected<void> independent_trials(int count, const std::string& name, const RunContext& context,
                                                const std::function<Expected<void>(int)>& trial);

}  // namespace rigcal
