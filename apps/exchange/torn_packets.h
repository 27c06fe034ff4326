#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

/// A packet file that goes on behind its last whole packet: how far it is whole, and why not further.
struct TornPackets {
  std::string path;
  std::uint64_t whole_bytes = 0;
  std::uint64_t torn_bytes = 0;
  std::string damage;         ///< One clause with the place in the file.
  bool must_be_kept = false;  ///< More than what a power cut tears: there may be good packets in it.
};

/// Reads a packet file to its end and touches nothing. Nothing where it is whole. Errors: it cannot be read, is no
/// packet file; a file that fails to be read is never taken for one that is torn.
[[nodiscard]] Expected<std::optional<TornPackets>> find_torn_packets(const std::string& path,
                                                                     const RunContext& context);

/// Whether what must be kept of all of these finds room on the disk.
[[nodiscard]] Expected<void> check_room(const std::vector<TornPackets>& all);

/// Cuts a file behind its last whole packet, or takes it away where there is none. What must be kept is then in a file
/// beside it, "lidar.pcapng.tail", which nobody takes for a part of the recording. Returns what was done, a clause.
/// After an Error the file is as it was.
[[nodiscard]] Expected<std::string> cut_torn_packets(const TornPackets& torn, const RunContext& context);

}  // namespace rigcal
