#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/capture/capture_status.h"
#include "apps/capture/packet_taker.h"
#include "apps/recording/session_counters.h"
#include "core/io/session_folder.h"
#include "drivers/net/session_clock.h"

namespace rigcal {

/// Pairs of clock readings, ten a second where CLOCK_REALTIME is being set, otherwise one in ten seconds.
class ClockPairs {
 public:
  void add(const net::ClockReading& reading);
  [[nodiscard]] const std::vector<ClockPair>& pairs() const { return pairs_; }

 private:
  std::vector<ClockPair> pairs_;
};

/// What the stamps of the LiDARs' streams say is missing, one sentence each, with its time.
[[nodiscard]] std::vector<std::string> stream_gaps(const Rig& rig, const IngestSummary& ingest);

using NamedCounters = SessionCounters::mapped_type;
/// What came of the talk with one LiDAR, and what of that with all of them got lost in this machine.
[[nodiscard]] NamedCounters link_counters(const livox::LinkCounters& counters);
[[nodiscard]] NamedCounters control_counters(const livox::ControlCounters& counters);
/// The ledger of a camera's frames and pulses, and the pulses of the rig's own lines.
[[nodiscard]] NamedCounters matching_counters(const MatchLedger& ledger);
[[nodiscard]] NamedCounters trigger_counters(const trigger::TriggerReport& report);

/// What session.json counts of a capture: by sensor, by interface, of the trigger, and of the recording itself.
[[nodiscard]] SessionCounters capture_counters(const Rig& rig, const PacketTaker::Figures& figures,
                                               const CaptureStatus& status,
                                               const std::vector<livox::InterfaceReport>& interfaces);

}  // namespace rigcal
