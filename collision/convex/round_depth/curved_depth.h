#pragma once

#include <cstdint>

#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

/// Queries with fewer iterations than this do without the search over directions: their callers
/// want little work [count].
inline constexpr int kLeastIterations = 64;

/// Cells, directions and planes that one of its iterations buys [count]. Each takes about 0.37 us,
/// so that the default limit of 256 iterations is less than a millisecond. About five of a thousand
/// pairs of the long run are left wider than asked: nearly coaxial ones, and corners next to a
/// round body's middle.
inline constexpr std::int64_t kCellsPerStep = 8;

/// The cost of one of its iterations beyond that of any other [units of Work].
inline constexpr std::int64_t kCurvedStepWork = 370 * kCellsPerStep;

/// True for the pairs of offerCurvedDepth(): one core at least is a cylinder, cone or ellipsoid;
/// the other is such a core, a point, segment or box, or the vertices of a ConvexHull.
bool haveCurvedDepth(const ConvexView& a, const ConvexView& b);

/// Both ends of the signed separation of two overlapping cores, one of them round. Made for
/// differences that are about as far out in many directions as in the nearest one: all around an
/// axis that both nearly share, or along a valley. An expanding polytope needs facets for all of
/// these directions, the more the narrower the interval. Here the support function h of the
/// difference is proven to be at least a depth d in all directions, by branch and bound over
/// triangles of directions, whose bound (cell_bound.h) errs by the fourth power of their size.
///
/// A convex combination of a core's pieces (rims, apex, ends, corners; curved_face.h) represents it
/// in a cell, chosen at the cell's three corners and linear between them. Any choice gives a bound.
/// Depths tend to be least at an edge of the difference, where one piece takes over from another.
/// There, for a direction e, the choice is the member y of the face with the largest
///   e . y - |y - (e . y) e|^2 / (2 d),
/// the one nearest to the direction. Then the bound does not drop beside the edge, d |x| bends by
/// less, and interpolating the choice errs by the fourth power, too.
///
/// Wherever h < d, Newton's steps descend to the nearest plane, along the edge if there is one, and
/// d becomes less: what has been proven stays proven. Two shortcuts come before cells: a point of
/// one core deep in the other, and for bodies of revolution about one axis the angles of a half
/// plane (common_axis.h). Rough depths are proven first. Three quarters of the work go to cells
/// that are halved as round parts bend, the rest, where these do not suffice, to cells that follow
/// edges.
///
/// False where less was proven than is asked. The caller's limit of iterations is granted once
/// more, kCellsPerStep each.
bool offerCurvedDepth(Difference<false>& difference, Progress& progress);

/// Both ends of the separation of two such cores that are apart, however little, where other
/// searches ended: Newton's steps to the farthest plane, along edges as above, and the member of
/// the difference's face there that is nearest to the plane's normal. Some tens of steps.
void offerCurvedNearest(Difference<false>& difference, Progress& progress);

}  // namespace leeway::collision
