#pragma once

#include <memory>
#include <span>

#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

/// ConvexHull::compute() for a part of a shape: the part may be smaller than a whole shape may be,
/// and its coordinates are not checked. `points`: at least one [m]. O(n log n) in practice.
std::shared_ptr<const ConvexHull> hullOfPart(std::span<const Eigen::Vector3d> points);

}  // namespace leeway::collision
