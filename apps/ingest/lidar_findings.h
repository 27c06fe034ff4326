#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/ingest/lidar_ingest.h"
#include "core/quality/result_evidence.h"

namespace rigcal {

/// What a user should know of the devices of a recording, in sentences.
[[nodiscard]] std::vector<std::string> ingest_warnings(const Rig& rig, const IngestSummary& summary);

/// Of the rig's LiDARs; where two devices say that they are one sensor, of the one with more packets.
[[nodiscard]] PacketCounters packet_counters(const Rig& rig, const IngestSummary& summary);

/// How the clocks of the rig's LiDARs were mapped to the session's, in the order of what was heard first.
[[nodiscard]] std::vector<ClockReport> clock_reports(const Rig& rig, const IngestSummary& summary);

/// What keeps a recording from being used with this rig, if anything does. A LiDAR without points does not where the
/// base has some, and another LiDAR or a camera is left to be placed: it is warned of, and failed in the end.
[[nodiscard]] std::optional<Error> ingest_error(const Rig& rig, const IngestSummary& summary, bool learned_too_late);

}  // namespace rigcal
