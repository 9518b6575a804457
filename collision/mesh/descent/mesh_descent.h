#pragma once

#include <algorithm>
#include <limits>

#include "collision/convex/convex_distance.h"
#include "collision/mesh/descent/descent_bounds.h"
#include "collision/mesh/descent/descent_side.h"

namespace leeway::collision {

/// Branch and bound over pairs of nodes, nearer ones first, with a stack of fixed size. Ends as
/// soon as the request is met. Once surfaces are known to overlap and a depth is requested, it
/// searches for deeper pairs with limited effort (kDeeperNodes). `cache` is read and updated; it
/// must not be null. Allocates nothing.
DescentResult descend(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement,
                      const DistanceRequest& request, Scratch& scratch, PairCache* cache);

/// Queries a pair of exact pieces by ask(threshold): first whether they are farther apart than the
/// bar, which may be infinite; if not, for their distance, unless the first answer suffices.
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

/// The distance of two convex pieces, or of their sweep.
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
