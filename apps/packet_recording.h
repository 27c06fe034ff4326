#pragma once

#include "apps/recording.h"
#include "apps/stop_reader.h"

namespace rigcal {

/// A packet dump (pcap, pcapng) becomes a recording: datagrams, points, stops, cells, in one pass and in memory that
/// does not grow with the dump. A dump in which a device names itself only after its first points is read twice.
[[nodiscard]] Expected<Recording> read_packets(const PacketSource& source, const CellOptions& cells,
                                               const RunContext& context);

}  // namespace rigcal
