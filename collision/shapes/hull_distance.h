#pragma once

#include <Eigen/Core>
#include <span>

#include "collision/shapes/hull_builder.h"

namespace leeway::collision {

/// An upper bound on the distance of `point` from the hull of `points` [m], rounding included; 0 if
/// it is outside no facet. O(facets).
double distanceFromHull(const Eigen::Vector3d& point, std::span<const Eigen::Vector3d> points,
                        const HullBuilder& hull);

/// The largest distanceFromHull() of hull.outside(); 0 if that is empty. Usually O(outside +
/// facets): a point whose distance from its own facet is within the largest distance so far needs
/// no other facet.
double largestDistanceFromHull(std::span<const Eigen::Vector3d> points, const HullBuilder& hull);

}  // namespace leeway::collision
