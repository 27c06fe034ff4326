#include "apps/capture/disk_wait.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace rigcal {
namespace {

constexpr std::chrono::milliseconds longest_look{200};

}  // namespace

DiskWait::DiskWait(const DiskPatience& patience, std::string what, const Heartbeat* worker)
    : patience_(patience), what_(std::move(what)), worker_(worker) {
  thread_ = std::jthread([this](const std::stop_token& stop) { look(stop); });
}

DiskWait::~DiskWait() = default;

void DiskWait::look(const std::stop_token& stop) const {
  const auto begun = SteadyClock::now();
  const auto told_after = std::chrono::duration<double>(patience_.told_after).count();
  const std::chrono::nanoseconds most = worker_ != nullptr ? patience_.most : patience_.most_unseen;
  const auto period = std::min<std::chrono::nanoseconds>(longest_look, patience_.told_after);
  std::mutex mutex;
  std::condition_variable_any ended;
  bool is_told = false;
  while (true) {
    std::unique_lock lock(mutex);
    if (ended.wait_for(lock, stop, period, [&stop] { return stop.stop_requested(); })) return;
    double still_s = seconds_since(begun);
    if (const double pause_s = worker_ != nullptr ? worker_->pause_s() : 0.0; pause_s > 0.0)
      still_s = std::min(still_s, pause_s);
    if (still_s >= told_after && !std::exchange(is_told, true) && patience_.tell) patience_.tell(what_);
    if (still_s < std::chrono::duration<double>(most).count()) continue;
    if (patience_.give_up) patience_.give_up(most);
    return;
  }
}

}  // namespace rigcal
