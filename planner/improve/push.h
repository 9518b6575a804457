#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "leeway/planner/edge_certifier.h"
#include "planner/improve/improve_path.h"

namespace leeway::planner {

struct PushOptions {
  double target = 0;   ///< clearance that every edge should keep [m]
  double least = 0;    ///< the least clearance to try for an edge that cannot keep the target [m]
  double longest = 0;  ///< greatest length of the path, in the space's distance
  Pairs pairs = Pairs::kWorld;  ///< that should keep the target; the others keep their margins
  std::int64_t work = 0;        ///< work limit of the whole push [units of collision::Work]
  std::function<bool()> stop;   ///< polled before every edge
};

/// Pushes a path off nearby obstacles, in place. If an edge does not keep the target, places around
/// it move along the gradients of the distances until the edges there keep it; if that fails, the
/// target is 3 mm, and finally `least`. Edges that keep less than `least` after all attempts stay
/// unchanged. Returns the clearance that `pairs` are proven to keep on the whole path [m]; 0 if
/// some edge stayed unchanged or the work limit was reached. Deterministic unless stopped.
double push(EdgeCertifier& certifier, Waypoints& path, const PushOptions& options);

/// Pushes the parts that do not limit a path's least clearance, `options.target`. The path between
/// the places near its ends with a greater clearance is pushed to keep more. The place that limits
/// it there divides it, and each part is pushed on its own. So the next worst place improves, and
/// then the next. The path keeps the clearance that it had. Returns the work of certifiers other
/// than the given one. Deterministic unless stopped. It makes a few pushes for each limiting place;
/// `least` and `work` have no effect.
EdgeCertifier::Statistics pushElsewhere(const std::shared_ptr<const CompiledScene>& scene,
                                        EdgeCertifier& certifier, Waypoints& path,
                                        const PushOptions& options);

}  // namespace leeway::planner
