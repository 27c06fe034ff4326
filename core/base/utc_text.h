#pragma once

#include <cstdint>
#include <string>

namespace rigcal {

/// Nanoseconds of UTC for people: "2026-11-21 21:10:03.512".
[[nodiscard]] std::string utc_text(std::int64_t unix_ns);

}  // namespace rigcal
