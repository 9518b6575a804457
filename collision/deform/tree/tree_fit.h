#pragma once

// Private to collision/: how well a hierarchy still fits its vertices.
//
// Decayed subtrees are rebuilt. Rejected: tree rotations (D. Kopta et al., "Fast, effective BVH
// updates for animated scenes", 2012), bottom-up: at every node the exchange of a grandchild with
// an uncle or a cousin that saves the most area, until none saves any. Measured with `leeway report
// deform --motion explode twist --no-rivals`: update and 12 distances of spheres, in us (on a busy
// machine: the rows of 200k are accurate to a third):
//
// clang-format off
//                   refit     rebuilt      rotated       rotated in
//                             as decayed   as decayed    every frame
//   twist     2k    3, 8      5, 8         6, 9          103, 10
//            20k    28, 21    49, 19       46, 21        2010, 23
//           200k    270, 60   465, 94                    80600, 131
//   explode   2k    9, 18     11, 14       16, 17        89, 18
//            20k    72, 43    103, 30      8340, 51      8250, 53
//           200k    1030, 330 187000, 196                245000, 434
// clang-format on
//
// When triangles fly apart, the leaves of eight triangles decay, and no rotation splits these. A
// twisted sheet leaves nothing to gain. After any exchange, slots and vertices must be laid out
// again.

#include <cstdint>
#include <span>
#include <vector>

#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// Fit of each node: its children's surface area divided by that of the box around them, which is
/// the cost for a query that opens the node; 0 for a node without area. All boxes must be known.
/// O(nodes). T. Larsson, T. Akenine-Moller, "A dynamic bounding volume hierarchy for generalized
/// collision detection", 2006, compare volumes instead.
void measureFit(const DeformTree& tree, std::span<const WideBox> boxes, std::vector<float>& fit);

/// Cost of a random query by the surface area heuristic: the surface area of all children of the
/// nodes 0 .. count - 1 divided by that of the root's box. 0 for a root without area.
double surfaceCost(std::span<const WideBox> boxes, std::int32_t count);

/// Finds nodes whose fit has grown by more than `factor` since `before`; none is below another.
void findDecayed(const DeformTree& tree, std::span<const float> fit, std::span<const float> before,
                 double factor, std::vector<std::int32_t>& roots);

}  // namespace leeway::collision
