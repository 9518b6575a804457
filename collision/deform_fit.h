#pragma once

// Private to collision/: how well a hierarchy still fits its vertices.

#include <cstdint>
#include <span>
#include <vector>

#include "collision/deform_tree.h"

namespace leeway::collision {

/// The children's surface area over that of the node itself, one a node (0 for one without area):
/// what a query pays at a node that it opens (T. Larsson, T. Akenine-Moller, "A dynamic bounding
/// volume hierarchy for generalized collision detection", 2006, compare volumes). All boxes must be
/// known. O(nodes).
void measureFit(const DeformTree& tree, std::span<const WideBox> boxes, std::vector<float>& fit);

/// The surface area of all children of the nodes 0 .. count - 1 over that of the root's own box:
/// the cost of a random query by the surface area heuristic. 0 for a root without area.
double surfaceCost(std::span<const WideBox> boxes, std::int32_t count);

/// Nodes whose fit has grown by more than `factor` since `before`, none below another.
void findDecayed(const DeformTree& tree, std::span<const float> fit, std::span<const float> before,
                 double factor, std::vector<std::int32_t>& roots);

}  // namespace leeway::collision
