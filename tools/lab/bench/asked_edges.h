#pragma once

// Edges that planning and simplifying request, replayed by measurements and checks. Not part of the
// product.

#include <memory>
#include <vector>

#include "leeway/planner/compiled_scene.h"

namespace leeway::bench {

struct AskedEdge {
  std::vector<double> a, b;
};

/// Ends of edges, two rows for each edge, in order of request.
struct AskedEdges {
  std::vector<std::vector<double>> planning, simplifying;

  /// At most `most` edges of both lists, evenly spaced.
  std::vector<AskedEdge> some(int most) const;
};

/// The edges that a seeded RRTConnect of at most `iterations` iterations, and simplify() on its
/// path, request from the certifier, from the problem's start to the middle of its first goal.
/// Empty if either end is invalid.
AskedEdges askedEdges(const planner::Problem& problem,
                      const std::shared_ptr<const planner::CompiledScene>& scene,
                      unsigned long long iterations);

}  // namespace leeway::bench
