#include "tests/support/allocation_counter.h"

#include <pthread.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {

thread_local std::uint64_t in_this_thread = 0;
std::atomic<std::uint64_t> in_receivers{0};

void* count(std::size_t size) {
  ++in_this_thread;
  char name[16] = {};
  if (pthread_getname_np(pthread_self(), name, sizeof name) == 0 && std::strcmp(name, "livox-receive") == 0)
    ++in_receivers;
  return std::malloc(size);
}

}  // namespace

void* operator new(std::size_t size) {
  if (void* memory = count(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace rigcal {

std::uint64_t allocations_in_this_thread() { return in_this_thread; }
std::uint64_t allocations_in_receivers() { return in_receivers; }

}  // namespace rigcal
