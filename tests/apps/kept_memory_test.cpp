#include "apps/kept_memory.h"

#include <gtest/gtest.h>

#include <vector>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace rigcal {
namespace {

TEST(KeptMemory, OfLargePiecesIsNotGivenBack) {
#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 33)
  keep_freed_memory();
  const std::size_t before = mallinfo2().hblkhd;
  const std::vector<char> large(std::size_t{200} << 20, 1);
  // What is mapped by itself is given back as soon as it is freed.
  EXPECT_EQ(before, mallinfo2().hblkhd);
  EXPECT_EQ(1, large.back());
#else
  GTEST_SKIP() << "the C library has no mallinfo2";
#endif
}

}  // namespace
}  // namespace rigcal
