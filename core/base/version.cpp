#include "core/base/version.h"

namespace rigcal {

const char* version() { return RIGCAL_VERSION; }

}  // namespace rigcal
