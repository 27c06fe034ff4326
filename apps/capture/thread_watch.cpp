#include "apps/capture/thread_watch.h"

#include <algorithm>
#include <cmath>

namespace rigcal {

std::vector<ThreadWatch::News> ThreadWatch::look() {
  std::vector<News> news;
  std::vector<std::string> stuck;
  for (const Heartbeat* thread : threads_) {
    const bool was_stuck = std::find(stuck_.begin(), stuck_.end(), thread->name()) != stuck_.end();
    const bool is_stuck = thread->pause_s() >= kStuckS;
    if (is_stuck) stuck.push_back(thread->name());
    if (is_stuck && !was_stuck)
      news.push_back({thread->name(), "has not moved for " + std::to_string(std::lround(kStuckS)) +
                                          " s: the disk, a device or other work of the machine holds it up"});
    if (was_stuck && !is_stuck) news.push_back({thread->name(), "moves again"});
  }
  stuck_ = std::move(stuck);
  return news;
}

void ThreadWatch::count(SessionCounters& counters) const {
  for (const Heartbeat* thread : threads_)
    counters["thread " + thread->name()] = {{"worst_pause_us", static_cast<std::uint64_t>(thread->worst_ns() / 1000)}};
}

}  // namespace rigcal
