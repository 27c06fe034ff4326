#include "apps/kept_memory.h"

#include <cstdlib>

// Only after a header of the C library is it known which one it is.
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace rigcal {

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int largest = 1 << 30;
  mallopt(M_MMAP_THRESHOLD, largest);
  mallopt(M_TRIM_THRESHOLD, largest);
#endif
}

}  // namespace rigcal
