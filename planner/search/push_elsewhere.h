#pragma once

#include <functional>
#include <memory>

#include "leeway/planner/edge_certifier.h"
#include "planner/search/connect_search.h"

namespace leeway::planner {

struct PushElsewhereOptions {
  double kept = 0;              ///< clearance that every edge keeps [m]
  double longest = 0;           ///< length that the path may have, in the space's distance
  Pairs pairs = Pairs::kWorld;  ///< whose clearance it is; the others keep their margins
  std::function<bool()> stop;   ///< asked before every edge
};

/// Pushes what does not limit a path's least clearance: the path between the places near its ends
/// that have more room keeps more; what limits it there divides it, and each part is pushed on its
/// own. So the next worst place gets better, and the next. What was kept is kept: a part is only
/// taken with all of its edges proven. Returns the work of certifiers beside the given one.
/// Deterministic unless stopped. A few pushes for each place that limits.
EdgeCertifier::Statistics pushElsewhere(const std::shared_ptr<const CompiledScene>& scene,
                                        EdgeCertifier& certifier, Waypoints& path,
                                        const PushElsewhereOptions& options);

}  // namespace leeway::planner
