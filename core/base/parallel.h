#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace rigcal {

/// How many threads `parallel_for` may use from now on (at least 1). Process-wide; call it once, before any work.
void set_thread_count(int threads);
[[nodiscard]] int thread_count();

/// Calls `body(begin, end)` for consecutive chunks of `grain` items (the last may be shorter) that cover 0 .. count -
/// 1, on several threads. Work is cut by size, never by the number of threads, so that results which depend on the
/// chunks only are the same to the bit whatever the number of threads. `body` must not throw.
void parallel_for(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body);

/// Sums `body(begin, end)` over the chunks of `parallel_for`, always added in the order of the chunks.
template <class Sum, class Body>
[[nodiscard]] Sum parallel_sum(std::size_t count, std::size_t grain, Sum zero, const Body& body) {
  const std::size_t chunks = (count + grain - 1) / grain;
  std::vector<Sum> parts(chunks, zero);
  parallel_for(count, grain, [&](std::size_t begin, std::size_t end) { parts[begin / grain] = body(begin, end); });
  Sum total = zero;
  for (const Sum& part : parts) total += part;
  return total;
}

}  // namespace rigcal
