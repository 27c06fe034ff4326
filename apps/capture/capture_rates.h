#pragma once

#include <cstdint>
#include <vector>

#include "apps/capture/capture_status.h"
#include "core/base/seconds.h"

namespace rigcal {

/// Packets and frames a second, from one showing of a capture to the next.
class CaptureRates {
 public:
  explicit CaptureRates(SteadyClock::time_point started) : last_(started) {}

  /// Fills in the rates since the last call.
  void add(CaptureStatus& status, SteadyClock::time_point now);

 private:
  SteadyClock::time_point last_;
  std::vector<std::uint64_t> packets_;  ///< By device, at `last_`.
  std::vector<std::uint64_t> frames_;   ///< By camera, likewise.
};

}  // namespace rigcal
