#include "core/turntable/coach.h"

#include <algorithm>
#include <cmath>

#include "core/base/text.h"

namespace rigcal {
namespace {

constexpr double usual_stops = 20.0;

std::string degrees(double value) {
  const auto tenths = std::lround(10.0 * value);
  return std::to_string(tenths / 10) + (tenths % 10 == 0 ? "" : "." + std::to_string(tenths % 10)) + " degrees";
}

std::string capturing(const CaptureProgress& progress) {
  if (progress.is_full) {
    return progress.turns_itself ? "done, the table turns"
                                 : "done, turn by " + degrees(step_deg(progress)) + " and hold still";
  }
  const double share = progress.dwell_s > 0.0 ? std::min(1.0, progress.rested_s / progress.dwell_s) : 1.0;
  if (share < 1.0)
    return "hold still: stop " + std::to_string(progress.stop) + ", " + std::to_string(std::lround(100.0 * share)) +
           " %";
  return "hold still: no image of " + joined(progress.awaited, ", ") + " yet";
}

}  // namespace

double step_deg(const CaptureProgress& progress) {
  return 360.0 / (progress.wanted_stops > 0 ? static_cast<double>(progress.wanted_stops) : usual_stops);
}

std::string advice(const CaptureProgress& progress) {
  switch (progress.state) {
    case CaptureState::idle:
      return "not begun";
    case CaptureState::checking:
      return "hold still: waiting for " + joined(progress.absent, ", ");
    case CaptureState::waiting_for_still:
      return progress.left_early ? "moved too early, that stop does not count: hold still" : "hold still";
    case CaptureState::settling:
      return "hold still: the swing fades";
    case CaptureState::capturing:
      return capturing(progress);
    case CaptureState::moving:
      return progress.table_is_turning ? "the table turns"
                                       : "turn by " + degrees(step_deg(progress)) + ", then hold still";
    case CaptureState::ended:
      return "ended: " + counted(progress.stops, "stop");
    case CaptureState::failed:
      return progress.failure;
  }
  return {};
}

}  // namespace rigcal
