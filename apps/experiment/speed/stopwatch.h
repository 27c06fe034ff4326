#pragma once

#include <time.h>

#include <functional>
#include <vector>

#include "core/base/median.h"
#include "core/base/seconds.h"

namespace rigcal::speed {

/// What some work took: by the clock on the wall, and of all threads together. The second says more on a machine that
/// has other work to do.
struct Took {
  double wall_s = 0.0;
  double cpu_s = 0.0;
};

inline Took took(const std::function<void()>& work) {
  const auto cpu_s = [] {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  };
  const double cpu_begin_s = cpu_s();
  const auto begin = SteadyClock::now();
  work();
  return {seconds_since(begin), cpu_s() - cpu_begin_s};
}

inline double seconds_of(const std::function<void()>& work) { return took(work).wall_s; }

/// The middle ones of some calls.
inline Took middle_of(int times, const std::function<void()>& work) {
  std::vector<double> wall_s;
  std::vector<double> cpu_s;
  for (int k = 0; k < times; ++k) {
    const Took one = took(work);
    wall_s.push_back(one.wall_s);
    cpu_s.push_back(one.cpu_s);
  }
  return {median(std::move(wall_s)), median(std::move(cpu_s))};
}

}  // namespace rigcal::speed
