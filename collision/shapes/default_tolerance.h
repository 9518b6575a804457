#pragma once

// Private to collision/: the tolerance of requests that name none.

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// The request with that tolerance [m]. (Member by member: a copy by vectors waits for what the
/// caller has just written in pieces.)
inline DistanceRequest withTolerance(const DistanceRequest& request, double tolerance) {
  return {tolerance, request.threshold, request.depth, request.iteration_limit, request.node_limit};
}

/// A body's part in defaultTolerance() [m]; half-spaces have no size.
inline double toleranceOf(double bounding_radius, double extent) {
  if (!std::isfinite(bounding_radius)) return 0;
  return std::max(std::min(kDefaultShare * bounding_radius, kDefaultTolerance),
                  kDefaultLeastShare * extent);
}

/// defaultTolerance() of two shapes whose frames are `offset` apart [m].
inline double toleranceOf(const Shape& a, const Shape& b, const Eigen::Vector3d& offset) {
  const double least = (kDefaultLeastShare * offset).lpNorm<1>(),
               tolerance = std::max(std::max(a.defaultTolerance(), b.defaultTolerance()), least);
  // Written so that a NaN, too, is none; what is infinite would be met by anything.
  return least < std::numeric_limits<double>::infinity() ? tolerance : 0;
}

}  // namespace leeway::collision
