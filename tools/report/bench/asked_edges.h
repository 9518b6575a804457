#pragma once

// Not part of the product: the edges that planning and simplifying ask for, to be measured and
// checked.

#include <memory>
#include <vector>

#include "leeway/planner/compiled_scene.h"

namespace leeway::bench {

/// Ends of edges, two rows each, in the order in which they were asked for.
struct AskedEdges {
  std::vector<std::vector<double>> planning, simplifying;
};

/// What a seeded RRTConnect of at most `iterations` looks and the shortening of its path ask of the
/// certifier, on the way from the problem's start to the middle of its first goal. Empty where one
/// of the two is not valid.
AskedEdges askedEdges(const planner::Problem& problem,
                      const std::shared_ptr<const planner::CompiledScene>& scene,
                      unsigned long long iterations);

}  // namespace leeway::bench
