#pragma once

#include <cstdint>

#include "planner/base/random.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {

/// Seed of the k-th run of a planner within one plan.
inline std::uint64_t runSeed(std::uint64_t seed, std::uint64_t run) {
  return Random(seed, kRunStream + run).next();
}

}  // namespace leeway::planner
