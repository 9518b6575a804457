#pragma once

// Private to collision/: the tolerance of requests that do not set one.

#include <algorithm>
#include <cmath>

#include "collision/base/tolerances.h"
#include "leeway/collision/query.h"

namespace leeway::collision {

/// The request with that tolerance [m]. (It is copied member by member, because a vector copy of
/// data that the caller has just written in pieces would stall.)
inline DistanceRequest withTolerance(const DistanceRequest& request, double tolerance) {
  return {tolerance, request.threshold, request.depth, request.iteration_limit, request.node_limit};
}

/// A body's contribution to defaultTolerance() [m]; half-spaces have no size.
inline double toleranceOf(double bounding_radius, double extent) {
  if (!std::isfinite(bounding_radius)) return 0;
  return std::max(std::min(kDefaultShare * bounding_radius, kDefaultTolerance),
                  kDefaultLeastShare * extent);
}

}  // namespace leeway::collision
