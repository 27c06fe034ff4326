#include "core/base/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>
#include <thread>

#ifdef RIGCAL_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace rigcal {
namespace {

struct Limit {
  int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::unique_ptr<tbb::global_control> control;
};

Limit& limit() {
  static Limit instance;
  return instance;
}

// The thread sanitizer cannot look into TBB and would call every hand-over between its threads a race. In its builds
// this file is compiled without it and says by itself that all before parallel_for comes before the bodies, and these
// before all that follows; what the bodies do to each other is still watched.
#ifdef RIGCAL_THREAD_SANITIZER
void comes_after(char& event) { __tsan_acquire(&event); }
void happened(char& event) { __tsan_release(&event); }
#else
void comes_after(char&) {}
void happened(char&) {}
#endif

}  // namespace

void set_thread_count(int threads) {
  Limit& l = limit();
  l.threads = std::max(1, threads);
  l.control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<std::size_t>(l.threads));
}

int thread_count() { return limit().threads; }

void parallel_for(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
  if (count == 0) return;
  grain = std::max<std::size_t>(1, grain);
  const std::size_t chunks = (count + grain - 1) / grain;
  const auto run = [&](std::size_t chunk) { body(chunk * grain, std::min(count, (chunk + 1) * grain)); };
  if (chunks == 1 || limit().threads == 1) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) run(chunk);
    return;
  }
  char begun = 0;
  char ended = 0;
  happened(begun);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    comes_after(begun);
    run(chunk);
    happened(ended);
  });
  comes_after(ended);
}

}  // namespace rigcal
