#pragma once

// Private to collision/: the tolerance of requests that name none.

#include <algorithm>
#include <cmath>

#include "leeway/collision/distance.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {

/// The request with that tolerance [m]; one that is NaN, of poses that are not finite, is 0.
/// (Member by member: a copy by vectors waits for what the caller has just written in pieces.)
inline DistanceRequest withTolerance(const DistanceRequest& request, double tolerance) {
  return {std::isnan(tolerance) ? 0 : tolerance, request.threshold, request.depth,
          request.iteration_limit, request.node_limit};
}

/// A body's part in defaultTolerance() [m]; half-spaces have no size.
inline double toleranceOf(double bounding_radius, double extent) {
  if (!std::isfinite(bounding_radius)) return 0;
  return std::max(std::min(kDefaultShare * bounding_radius, kDefaultTolerance),
                  kDefaultLeastShare * extent);
}

/// defaultTolerance() of two shapes whose frames are `offset` apart [m].
inline double toleranceOf(const Shape& a, const Shape& b, const Eigen::Vector3d& offset) {
  return std::max(std::max(a.defaultTolerance(), b.defaultTolerance()),
                  kDefaultLeastShare * offset.lpNorm<1>());
}

}  // namespace leeway::collision
