#pragma once

#include <chrono>
#include <thread>

namespace rigcal {

/// Waits for it, ten seconds at most.
template <class Condition>
bool comes_true(const Condition& condition) {
  for (int i = 0; i < 2000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return condition();
}

}  // namespace rigcal
