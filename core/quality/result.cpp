#include "core/quality/result.h"

namespace rigcal {

const char* to_string(Status status) {
  switch (status) {
    case Status::good:
      return "good";
    case Status::weak:
      return "weak";
    case Status::failed:
      return "failed";
  }
  return "failed";
}

}  // namespace rigcal
