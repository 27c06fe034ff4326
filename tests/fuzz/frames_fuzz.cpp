// frames.csv, trigger.csv and turntable.csv of any bytes: no crash, and what is accepted makes sense.
#include <string>

#include "core/io/frame_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string text(bytes, bytes + size);
  if (const auto frames = rigcal::parse_frames(text, "frames.csv")) {
    for (const rigcal::FrameRecord& frame : *frames)
      if (frame.file.empty() || frame.file.find('/') != std::string::npos || frame.stamp_ns < 0) __builtin_trap();
  }
  if (const auto pulses = rigcal::parse_trigger(text, "trigger.csv")) {
    for (std::size_t i = 1; i < pulses->size(); ++i)
      if ((*pulses)[i].stamp_ns <= (*pulses)[i - 1].stamp_ns) __builtin_trap();
  }
  if (const auto angles = rigcal::parse_turntable(text, "turntable.csv")) {
    for (std::size_t i = 1; i < angles->size(); ++i)
      if ((*angles)[i].stamp_ns <= (*angles)[i - 1].stamp_ns) __builtin_trap();
  }
  return 0;
}
