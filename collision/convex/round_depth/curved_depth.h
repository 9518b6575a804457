#pragma once

#include <cstdint>

#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

/// Queries with fewer iterations than this skip the search over directions, because their callers
/// want little work [count].
inline constexpr int kLeastIterations = 64;

/// Cells, directions and planes for each iteration of this search [count]. Each takes about 0.37
/// us, so the default limit of 256 iterations is less than a millisecond. About five in a thousand
/// pairs of the long run stay wider than requested: nearly coaxial ones, and corners next to a
/// round body's middle.
inline constexpr std::int64_t kCellsPerStep = 8;

/// The additional cost of one of its iterations [units of Work].
inline constexpr std::int64_t kCurvedStepWork = 370 * kCellsPerStep;

/// True for the pairs of offerCurvedDepth(): at least one core is a cylinder, cone or ellipsoid;
/// the other is such a core, a point, segment or box, or the vertices of a ConvexHull.
bool haveCurvedDepth(const ConvexView& a, const ConvexView& b);

/// Finds both ends of the signed separation of two overlapping cores, one of them round. It is made
/// for differences that are about as far out in many directions as in the nearest one: all around
/// an axis that both nearly share, or along a valley. An expanding polytope needs facets for all of
/// these directions, and more of them for narrower intervals. Here the support function h of the
/// difference is proven to be at least a depth d in all directions, by branch and bound over
/// triangles of directions, whose bound (cell_bound.h) errs by the fourth power of their size.
///
/// A cell represents a core by a convex combination of its pieces (rims, apex, ends, corners;
/// curved_face.h), chosen at the cell's three corners and linear between them. Any choice gives a
/// bound. Depths are often least at an edge of the difference, where one piece takes over from
/// another. There, for a direction e, the choice is the member y of the face with the largest
///   e . y - |y - (e . y) e|^2 / (2 d),
/// the one nearest to the direction. With this choice the bound does not drop next to the edge, d
/// |x| bends by less, and interpolating the choice also errs by the fourth power.
///
/// Wherever h < d, Newton steps descend to the nearest plane, along the edge if there is one, and d
/// decreases; what has been proven stays proven. Two shortcuts are tried before cells: a point of
/// one core deep in the other, and for bodies of revolution about one axis the angles of a half
/// plane (common_axis.h). Rough depths are proven first. Three quarters of the work go to cells
/// that are halved as round parts bend. If these do not suffice, the rest goes to cells that follow
/// edges.
///
/// False if less was proven than requested. The search may use the caller's limit of iterations
/// once more, with kCellsPerStep cells each.
bool offerCurvedDepth(Difference<false>& difference, Progress& progress);

/// Finds both ends of the separation of two such cores that are apart, however little, where other
/// searches ended: Newton steps to the farthest plane, along edges as above, and the member of the
/// difference's face there that is nearest to the plane's normal. It takes a few tens of steps.
void offerCurvedNearest(Difference<false>& difference, Progress& progress);

}  // namespace leeway::collision
