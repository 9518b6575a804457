#pragma once

#include <Eigen/Core>
#include <span>

#include "collision/mesh/mesh_tree.h"

namespace leeway::collision {

/// A proven upper bound on the largest distance of a point of the convex hull's surface from the
/// mesh [m], usually within 5 % or 1e-7 m of it. The distance from one triangle is a convex
/// function, so over a part of a facet it is largest at a corner. Facets are cut until the largest
/// such bound is close to a distance that is attained. Work is limited: at the limit (about 0.1 s)
/// the bound is looser.
double hullExcess(std::span<const Eigen::Vector3d> vertices, const MeshTree& tree);

}  // namespace leeway::collision
