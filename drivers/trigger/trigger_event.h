#pragma once

#include <cstdint>

namespace rigcal::trigger {

enum class TriggerSource { output, strobe, pps };

enum class TriggerEventKind {
  pulse,     ///< A pulse began: set on the output, seen on the strobe line, or reported as PPS.
  end,       ///< A pulse on the output or the strobe line ended; not told where the line was lost within it.
  lost,      ///< The chip or device is gone; it is looked for until it is back.
  returned,  ///< It is back.
  finished,  ///< All pulses of the pattern are done.
};

struct TriggerEvent {
  TriggerSource source = TriggerSource::output;
  TriggerEventKind kind = TriggerEventKind::pulse;
  std::int64_t number = 0;    ///< Of pulses, by source: from 0; of a PPS the kernel's own.
  std::int64_t stamp_ns = 0;  ///< Session time.
};

}  // namespace rigcal::trigger
