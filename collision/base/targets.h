#pragma once

// Which of Highway's targets are built: AVX-512, AVX2, SSE4 and plain code on x86. Those left out
// are hardly faster than the next one that is built, or have vectors of unknown length, which
// cannot stand in a struct. Whatever includes Highway includes this first: its inline functions
// depend on the choice, and must be the same in every file that is linked together.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
