#pragma once

// Private to collision/: how well a hierarchy still fits its vertices.
//
// Subtrees that decayed are built anew; there are no tree rotations (D. Kopta et al., "Fast,
// effective BVH updates for animated scenes", 2012). A rotation leads from the refitted hierarchy
// towards one built anew for the same vertices, and bench_deform, over 100 frames of a cloth, finds
// little to gain on that way: 12 distances against the refitted hierarchy take 0.7 to 1.4 (waves)
// and less than 0.5 (exploding) of what they take against one rebuilt in every frame, whose leaves
// no longer are neighbours in the mesh. What pays is to lose less, not to
// search.

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
