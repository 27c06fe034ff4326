#pragma once

#include <cstdint>
#include <string>

namespace rigcal {

/// Something that happened to a sensor or a line during a capture.
struct CaptureEvent {
  std::int64_t stamp_ns = 0;  ///< Session time.
  std::string text;
  bool is_gap = false;
};

}  // namespace rigcal
