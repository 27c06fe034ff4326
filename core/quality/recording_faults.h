#pragma once

#include <string>
#include <vector>

#include "core/quality/result_evidence.h"

namespace rigcal {

/// What went wrong on the way from a sensor into the recording, in a clause that a user can act on. It is no verdict on
/// the extrinsics: stops are long, and what is lost or late of them need not spoil anything.
struct RecordingFault {
  enum class Kind { loss, clock };

  std::string sensor;
  Kind kind = Kind::loss;
  std::string what;
};

/// All of them in a few words: "packets lost (avia, left); clock (left)". Empty where there are none.
[[nodiscard]] std::string faults_in_brief(const std::vector<RecordingFault>& faults);

/// "avia: 3.1 % of ..."
[[nodiscard]] std::string to_string(const RecordingFault& fault);

/// What the counters and the clocks of all sensors show: more packets lost than one in a thousand, clocks that were
/// set, that run as no quartz does, that stamp senselessly, and packets that come so late that they end in another
/// stop. In the order of the names; of one sensor losses first.
[[nodiscard]] std::vector<RecordingFault> recording_faults(const PacketCounters& packets,
                                                           const std::vector<ClockReport>& clocks);

}  // namespace rigcal
