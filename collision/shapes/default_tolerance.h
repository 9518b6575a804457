#pragma once

// Private to collision/: the tolerance of requests that name none.

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// The request with that tolerance [m]. (Member by member: a vector copy of what the caller has
/// just written in pieces would stall.)
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
  const double least = (kDefaultLeastShare * offset).lpNorm<1>() + kLeastSum,
               tolerance = std::max(std::max(a.defaultTolerance(), b.defaultTolerance()), least);
  // 0 for NaN and infinity: any interval would meet an infinite tolerance.
  return least < std::numeric_limits<double>::infinity() ? tolerance : 0;
}

}  // namespace leeway::collision
