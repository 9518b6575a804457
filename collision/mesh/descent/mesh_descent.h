#pragma once

#include <algorithm>
#include <limits>

#include "collision/convex/convex_distance.h"
#include "collision/mesh/mesh_tree.h"

namespace leeway::collision {

/// One of the two bodies of a descent: a hierarchy, or a convex shape as a whole (tree is null).
struct DescentSide {
  const MeshTree* tree = nullptr;
  ConvexView view;            ///< of a convex shape
  Eigen::Vector3d center;     ///< of a sphere that holds it, in its own frame
  double radius = 0;          ///< of that sphere; may be infinite
  Eigen::Vector3d low, high;  ///< a box that holds it, in its own frame; may be infinite
  double hull_excess = 0;     ///< of a mesh, as TriangleMesh::hullExcess() [m]
  double extent = 0;  ///< no point is farther from its frame's origin; infinite for a half-space
};

DescentSide descentSide(const Shape& shape);

/// Where A is, seen from B; with `swept`, at the beginning and at the end.
struct DescentPlacement {
  Pose X_BA0, X_BA1;
  bool swept = false;
  double growth = 0;  ///< [m]
  double slack = 0;   ///< see convexDistance() [m]
};

/// What the pieces of two bodies are apart: the minimum over all pairs of triangles (or the convex
/// shape itself). This knows nothing of insides.
struct DescentResult {
  double lower =
      0;  ///< no pair of pieces is nearer (or, below 0, deeper); -infinity: nothing is known
  double upper = 0;  ///< some pair is as near
  double hull_lower =
      0;  ///< proven for the hulls of the bodies, and with them for whatever is inside
  DistanceResult witness;  ///< of the pair that carries `upper`, in B
  int iterations = 0;
  int visited = 0;         ///< of request.node_limit; descend() alone tells it
  bool misplaced = false;  ///< a deforming triangle that was looked at is nowhere: not finite
};

/// Branch and bound over pairs of nodes, nearer ones first, with a stack of fixed size. Ends as
/// soon as the request is met; where `upper` is not positive and a depth is asked, it goes on for a
/// while to find deeper pairs. `cache` is used and updated; it may not be null.
DescentResult descend(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement,
                      const DistanceRequest& request, Scratch& scratch, PairCache* cache);

/// A pair of exact pieces: whether they are farther than the bar, which may be infinite, and how
/// far exactly where they are not, unless that is enough or does not matter any more.
/// ask(threshold) answers for them.
template <class Ask>
DistanceResult askOfPieces(double bar, const DistanceRequest& request, bool depth, const Ask& ask) {
  const bool bounded = bar < std::numeric_limits<double>::infinity();
  DistanceResult r = ask(bounded ? bar : std::numeric_limits<double>::quiet_NaN());
  if (!bounded || r.distance.lower > bar || r.status == DistanceStatus::kConverged ||
      bar == request.threshold || r.distance.upper <= request.threshold ||
      (!depth && r.distance.upper <= 0))
    return r;
  const double lower = r.distance.lower;
  r = ask(request.threshold);
  r.distance.lower = std::max(r.distance.lower, lower);
  return r;
}

/// One answer for such a pair.
inline DistanceResult pieceDistance(const ConvexView& a, const ConvexView& b,
                                    const DescentPlacement& placement,
                                    const DistanceRequest& request, Scratch& scratch,
                                    PairCache* cache) {
  return placement.swept
             ? convexSweptDistance(a, placement.X_BA0, placement.X_BA1, placement.growth, b,
                                   request, scratch, cache, placement.slack)
             : convexDistance(a, placement.X_BA0, b, request, scratch, cache, placement.slack);
}

}  // namespace leeway::collision
