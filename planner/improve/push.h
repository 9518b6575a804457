#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "leeway/planner/edge_certifier.h"
#include "planner/improve/improve_path.h"

namespace leeway::planner {

struct PushOptions {
  double target = 0;            ///< clearance that every edge is to keep [m]
  double least = 0;             ///< what an edge is to keep at least where it cannot keep that [m]
  double longest = 0;           ///< length that the path may have, in the space's distance
  Pairs pairs = Pairs::kWorld;  ///< that are to keep the target; the others keep their margins
  std::int64_t work = 0;        ///< all that it may cost [units of collision::Work]
  std::function<bool()> stop;   ///< asked before every edge
};

/// Pushes a path off what is near, in place: where an edge does not keep the target, places around
/// move along the gradients of the distances until these edges keep it; where that fails, 3 mm, at
/// last `least`. Edges that keep less than `least` whatever is tried stay as they are. Returns
/// what `pairs` are proven to keep on the whole path [m]; 0 where some edge stayed or the work
/// ended. Deterministic unless stopped.
double push(EdgeCertifier& certifier, Waypoints& path, const PushOptions& options);

/// Pushes what does not limit a path's least clearance, which is `options.target`: the path between
/// the places near its ends that have more room keeps more; what limits it there divides it, and
/// each part is pushed on its own. So the next worst place gets better, and the next. What was kept
/// is kept. Returns the work of certifiers beside the given one. Deterministic unless stopped. A
/// few pushes for each place that limits; `least` and `work` have no effect.
EdgeCertifier::Statistics pushElsewhere(const std::shared_ptr<const CompiledScene>& scene,
                                        EdgeCertifier& certifier, Waypoints& path,
                                        const PushOptions& options);

}  // namespace leeway::planner
