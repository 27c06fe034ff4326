#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "apps/ingest/ingest_summary.h"
#include "core/rig/rig.h"

namespace rigcal {

/// The counters of session.json: by sensor (by address where it is none of the rig's), then by name.
using SessionCounters = std::map<std::string, std::map<std::string, std::uint64_t>>;
[[nodiscard]] SessionCounters session_counters(const Rig& rig, const IngestSummary& ingest);

}  // namespace rigcal
