#pragma once

#include <cstdint>

#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

/// A query that may take fewer iterations than this is left as it is: its caller wants little work.
inline constexpr int kLeastIterations = 64;

/// What one of its iterations counts for beyond any other [units of Work]: 320 cells.
inline constexpr std::int64_t kCurvedStepWork = 250'000;

/// True for pairs that offerCurvedDepth() knows: one core at least is a cylinder, cone or
/// ellipsoid, the other that, a point, segment or box, or the vertices of a ConvexHull.
bool haveCurvedDepth(const ConvexView& a, const ConvexView& b);

/// Both ends of the signed separation of two overlapping cores of which one is round, where their
/// difference is about as far out in many directions as in the nearest one: all around an axis that
/// both nearly share, or along a valley of any shape. An expanding polytope needs facets for all of
/// it then, and more the narrower the interval is to be. Here the support function h of the
/// difference is itself proven to be at least a depth d in all directions, by branch and bound over
/// triangles of directions, whose bound (cell_bound.h) errs by the fourth power of their size.
///
/// In a cell each core is stood for by a convex combination of its pieces (rims, apex, ends,
/// corners; curved_face.h) that is chosen at its three corners and linear between them. At an edge
/// of the core's surface, where one piece takes over from the other and depths like to be least, it
/// is the combination whose member lies nearest to the direction: for a direction e and members y
/// of the face there the one with the largest e . y - |y - (e . y) e|^2 / (2 d). Then the bound
/// does not fall beside the edge, d |x| bends by less, and what the combinations' interpolation
/// errs by is of the fourth power, too. (Any choice is a bound.)
///
/// Wherever a direction is met in which h is less than d, Newton's steps look for the nearest plane
/// from there, along the edge if it is on one, and d becomes less: what has been proven stays so.
/// False where less was proven than is asked. The caller's limit of
/// iterations is granted once more, up to 320 cells a step: most often thousands in all.
/// Half of that is for cells that are halved as round parts bend, the rest for others that follow
/// edges, where the first did not come to an end. A rough depth is proven first.
bool offerCurvedDepth(Difference<false>& difference, Progress& progress);

/// Both ends of the separation of two such cores that are apart, however little, where other
/// searches ended: Newton's steps for the plane that is the farthest, along edges as above, and the
/// member of the difference that the direction's face has nearest to its line. Some tens of steps.
void offerCurvedNearest(Difference<false>& difference, Progress& progress);

}  // namespace leeway::collision
