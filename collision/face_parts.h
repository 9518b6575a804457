#pragma once

// Private to collision/: surfaces as polygons, and what planes leave of them.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "leeway/collision/coarse_shape.h"

namespace leeway::collision {

/// Convex polygons whose hulls, part by part, hold what is to be covered.
using Polygon = std::vector<Eigen::Vector3d>;

/// A ball around the points: steps towards the farthest of them (Badoiu and Clarkson, "Smaller
/// core-sets for balls", 2003), so that its centre stays between them; the best centre counts.
/// O(points).
Ball ballAround(std::span<const Polygon> faces);

/// The part of a convex polygon on one side of the plane x[axis] = at; corners on it stay.
Polygon clipped(const Polygon& polygon, Eigen::Index axis, double at, double side);

}  // namespace leeway::collision
