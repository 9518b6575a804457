#pragma once

#include <Eigen/Core>
#include <span>

#include "collision/shapes/hull_builder.h"

namespace leeway::collision {

/// An upper bound on the distance of `point` from the hull of `points` [m], rounding included: 0
/// when it is outside of no facet. O(facets).
double distanceFromHull(const Eigen::Vector3d& point, std::span<const Eigen::Vector3d> points,
                        const HullBuilder& hull);

/// The largest distanceFromHull() of hull.outside(); 0 for none. O(outside + facets) as a rule: a
/// point whose distance from its own facet is within the largest distance met needs no other facet.
double largestDistanceFromHull(std::span<const Eigen::Vector3d> points, const HullBuilder& hull);

}  // namespace leeway::collision
