#include "core/stops/still_listener.h"

namespace rigcal {

const char* to_string(DropReason reason) {
  switch (reason) {
    case DropReason::before_first_stop:
      return "before_first_stop";
    case DropReason::moving:
      return "moving";
    case DropReason::swing:
      return "swing";
    case DropReason::short_stop:
      return "short_stop";
    case DropReason::overflow:
      return "overflow";
    case DropReason::late:
      return "late";
    case DropReason::after_last_stop:
      return "after_last_stop";
  }
  return "";
}

const char* to_string(StopEnd end) {
  switch (end) {
    case StopEnd::motion:
      return "motion";
    case StopEnd::creep:
      return "creep";
    case StopEnd::silence:
      return "silence";
    case StopEnd::stream:
      return "stream";
  }
  return "";
}

}  // namespace rigcal
