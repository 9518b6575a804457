#pragma once

// The targets of Highway that are built: AVX-512, AVX2, SSE4 and plain code on x86. Two kinds are
// excluded: targets that are hardly faster than the next one that is built, and targets whose
// vectors have a length unknown at compile time, which cannot be members of a struct. Include this
// before Highway: its inline functions depend on the choice and must be the same in all files that
// are linked together.
#define LEEWAY_UNUSED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#ifdef __SANITIZE_ADDRESS__  // compiling takes long there, and SSE4 has nothing of its own
#define HWY_DISABLED_TARGETS (LEEWAY_UNUSED_TARGETS | HWY_SSE4)
#else
#define HWY_DISABLED_TARGETS LEEWAY_UNUSED_TARGETS
#endif
