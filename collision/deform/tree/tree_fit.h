#pragma once

// Private to collision/: how well a hierarchy still fits its vertices.
//
// Subtrees that decayed are built anew. Tree rotations (D. Kopta et al., "Fast, effective BVH
// updates for animated scenes", 2012) were built in their place and taken back: bottom-up, at every
// node, the exchange of a grandchild with an uncle or a cousin that saves the most area, until none
// does. `leeway report deform --motion explode twist --no-rivals` with each printed, in us, update
// and 12 distances of spheres (on a busy machine: 200k is good to a third):
//
//                   refit     built anew   rotated       rotated in
//                             as decayed   as decayed    every frame
//   twist     2k    3, 8      5, 8         6, 9          103, 10
//            20k    28, 21    49, 19       46, 21        2010, 23
//           200k    270, 60   465, 94                    80600, 131
//   explode   2k    9, 18     11, 14       16, 17        89, 18
//            20k    72, 43    103, 30      8340, 51      8250, 53
//           200k    1030, 330 187000, 196                245000, 434
//
// Leaves of eight triangles are what decays when triangles fly apart, and no rotation takes those
// apart; a twisted sheet leaves nothing to gain; and whatever is exchanged, slots and vertices have
// to be put in order again.

#include <cstdint>
#include <span>
#include <vector>

#include "collision/deform/tree/deform_tree.h"

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
