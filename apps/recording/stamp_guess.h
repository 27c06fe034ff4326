#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/records/records.h"

namespace rigcal {

/// Where the nearest stop lies, seen from a stamp outside of all: "0.100 s after stop 3".
[[nodiscard]] std::string nearest_stop(const std::vector<Stop>& stops, std::int64_t stamp_ns);

/// What may be wrong with stamps none of which lies in a stop, with the mend, in a clause: another unit than
/// nanoseconds, or a clock that is off by the same everywhere. Empty where neither would put all of them into stops.
[[nodiscard]] std::string guess_of_stamps(const std::vector<std::int64_t>& stamps_ns, const std::vector<Stop>& stops);

}  // namespace rigcal
