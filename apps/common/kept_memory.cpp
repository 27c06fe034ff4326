#include "apps/common/kept_memory.h"

#include <sys/types.h>

#include <cstddef>
#include <initializer_list>

// Only after a header of the C library is it known which one it is.
#ifdef __GLIBC__
#include <malloc.h>
#endif

extern "C" {
// jemalloc reads it before the program begins. Pages of 4 KiB are met one by one as memory is first written to, which
// takes longer than what is done in it.
const char* malloc_conf = "thp:always";
// Of jemalloc, where the program is linked with it; as the header of the library has it.
int mallctl(const char* name, void* old, std::size_t* old_size, void* value, std::size_t value_size) noexcept
    __attribute__((weak));
}

namespace rigcal {
namespace {

constexpr int largest = 1 << 30;

// Of all arenas to come, and of the one that is there: no pages are ever given back.
void keep_in_jemalloc() {
  for (const char* name :
       {"arenas.dirty_decay_ms", "arenas.muzzy_decay_ms", "arena.0.dirty_decay_ms", "arena.0.muzzy_decay_ms"}) {
    ssize_t never = -1;
    mallctl(name, nullptr, nullptr, &never, sizeof(never));
  }
}

// All arenas at once (MALLCTL_ARENAS_ALL); how long they keep pages does not matter to it.
constexpr const char* purge_all = "arena.4096.purge";

}  // namespace

void keep_freed_memory() {
  if (&mallctl != nullptr) {
    keep_in_jemalloc();
    return;
  }
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, largest);
  mallopt(M_TRIM_THRESHOLD, largest);
#endif
}

void give_back_freed_memory() {
  if (&mallctl != nullptr) {
    mallctl(purge_all, nullptr, nullptr, nullptr, 0);
    return;
  }
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace rigcal
