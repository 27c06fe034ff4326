#pragma once

#include <cstddef>

/// Before a function: it is compiled for wide vectors, too, and the program takes the version that the processor can
/// do. The sums are the same to the bit, since multiplications and additions are not fused; so it is for plain loops
/// over arrays whose rounds do not depend on each other. Not with sanitizers, which do not know of functions that are
/// chosen when the program is loaded, nor with GCC before 12, which does not know these names of processors.
#if defined(__x86_64__) && defined(__GNUC__) && __GNUC__ >= 12 && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define RIGCAL_WIDE __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#define RIGCAL_HAS_WIDE 1
#else
#define RIGCAL_WIDE
#define RIGCAL_HAS_WIDE 0
#endif

/// Before a loop over arrays of which none that is written overlaps another: where there are many the compiler does not
/// look whether they do, and takes one round after the other.
#if defined(__GNUC__) && !defined(__clang__)
#define RIGCAL_APART _Pragma("GCC ivdep")
#else
#define RIGCAL_APART
#endif

namespace rigcal {

/// Eight doubles side by side, as the widest registers hold them.
struct alignas(64) EightLanes {
  static constexpr std::size_t count = 8;
  double __attribute__((vector_size(64))) v = {};
};

/// Whether functions for wide vectors have registers of eight doubles; else, at most four.
[[nodiscard]] inline bool has_wide_registers_of_eight() {
#if RIGCAL_HAS_WIDE
  return __builtin_cpu_supports("x86-64-v4") != 0;
#else
  return false;
#endif
}

}  // namespace rigcal
