#include "apps/common/kept_memory.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <vector>

namespace rigcal {
namespace {

// Pages that were met for the first time, whoever allocates memory in this program.
long pages_met() {
  rusage usage{};
  EXPECT_EQ(0, getrusage(RUSAGE_SELF, &usage));
  return usage.ru_minflt;
}

long pages_met_by_200_mb() {
  const long before = pages_met();
  const std::vector<char> large(std::size_t{200} << 20, 1);
  EXPECT_EQ(1, large.back());
  return pages_met() - before;
}

TEST(KeptMemory, OfLargePiecesIsNotMetAnew) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers keep freed memory from being used again";
#endif
  keep_freed_memory();
  const long first = pages_met_by_200_mb();
  // Huge pages are 512 times as large as others where those have 4 KiB, 2048 times where they have 16 KiB.
  EXPECT_GT(first, sysconf(_SC_PAGESIZE) == 4096 ? 80 : 4) << "not even huge pages are so few";
  EXPECT_LT(pages_met_by_200_mb(), first / 10);
}

}  // namespace
}  // namespace rigcal
