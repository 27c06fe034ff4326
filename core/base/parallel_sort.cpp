#include "core/base/parallel_sort.h"

#include <tbb/parallel_sort.h>

#include <algorithm>

namespace rigcal {

void parallel_sort(std::vector<std::pair<std::uint64_t, std::uint32_t>>& numbered_keys) {
#ifdef RIGCAL_THREAD_SANITIZER
  // It cannot look into TBB, see parallel.cpp.
  std::sort(numbered_keys.begin(), numbered_keys.end());
#else
  tbb::parallel_sort(numbered_keys.begin(), numbered_keys.end());
#endif
}

}  // namespace rigcal
