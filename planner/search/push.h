#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "leeway/planner/edge_certifier.h"

namespace leeway::planner {

struct PushOptions {
  double target = 0;            ///< clearance that every edge is to keep [m]
  double least = 0;             ///< targets are halved down to that [m]
  double longest = 0;           ///< length that the path may have, in the space's distance
  Pairs pairs = Pairs::kWorld;  ///< that are to keep the target; the others keep their margins
  std::int64_t work = 0;        ///< all that it may cost [units of collision::Work]
  std::function<bool()> stop;   ///< asked before every edge
};

/// Moves waypoints of a path along the gradients of what is too near, and adds some, until every
/// edge is proven to keep the target, or a part of it. Only a whole path that is proven is taken;
/// its ends never change. Returns what `pairs` are proven to keep [m]; 0, with the path as it was,
/// where no target is reached. Deterministic unless stopped.
double push(EdgeCertifier& certifier, std::vector<std::vector<double>>& path,
            const PushOptions& options);

}  // namespace leeway::planner
