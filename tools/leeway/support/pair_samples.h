#pragma once

#include <cstdint>
#include <vector>

#include "leeway/planner/compiled_scene.h"

namespace leeway::tools {

/// How often the two bodies of one scene pair were within their margin at random configurations.
struct PairSamples {
  int pair = -1;
  int hits = 0;
};

/// Asks all pairs of two moving bodies at `samples` configurations, uniform within the limits of
/// the planned variables (unlimited ones within +-pi, the others as in the problem). What this
/// suggests is a hint to a user: every pair stays checked. Same seed, same counts. O(samples *
/// pairs).
std::vector<PairSamples> samplePairs(const planner::CompiledScene& scene, int samples,
                                     std::uint64_t seed);

}  // namespace leeway::tools
