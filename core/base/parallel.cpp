#include "core/base/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>
#include <thread>

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
  tbb::parallel_for(std::size_t{0}, chunks, run);
}

}  // namespace rigcal
