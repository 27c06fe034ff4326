#include "apps/experiment/speed/bandwidth.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <vector>

#include "apps/experiment/speed/stopwatch.h"
#include "core/base/parallel.h"

namespace rigcal::speed {
namespace {

constexpr int repetitions = 5;
constexpr std::size_t block = std::size_t{1} << 17;  // words of a piece that one thread takes

using Words = std::vector<std::uint64_t>;

std::uint64_t sum_of(const std::uint64_t* begin, std::size_t count) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += begin[i];
  return sum;
}

double fastest(const std::function<void()>& work) {
  double best = 1e30;
  for (int k = 0; k < repetitions; ++k) best = std::min(best, seconds_of(work));
  return best;
}

}  // namespace

Bandwidth measure_bandwidth(std::size_t bytes) {
  const std::size_t words = std::max(block, bytes / sizeof(std::uint64_t));
  Words from(words, 1);
  Words to(words, 0);
  std::atomic<std::uint64_t> total{0};
  const double read_s = fastest([&] {
    parallel_for(words, block, [&](std::size_t begin, std::size_t end) { total += sum_of(&from[begin], end - begin); });
  });
  const double copy_s = fastest([&] {
    parallel_for(words, block, [&](std::size_t begin, std::size_t end) {
      std::memcpy(&to[begin], &from[begin], (end - begin) * sizeof(std::uint64_t));
    });
  });
  // The sums are used, so that no compiler leaves them out.
  const auto once = static_cast<double>(total.load() / repetitions * sizeof(std::uint64_t));
  return {once / read_s, 2.0 * once / copy_s};
}

}  // namespace rigcal::speed
