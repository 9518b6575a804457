#pragma once

// Private to collision/: distance between two convex pieces, for the dispatcher, meshes and scenes.

#include "collision/convex/gjk/convex_view.h"
#include "leeway/collision/query.h"

namespace leeway::collision {

struct VertexStart;  // convex/hull_pairs.h

/// Signed separation of two convex pieces, in frame B: points and normal are in B. X_BA is taken as
/// the affine map that it is; what is known of its own error goes into `slack` [m], by which both
/// ends are widened (before thresholds and tolerance are looked at). cache may be null. `start`:
/// where a search on the vertices of this pair has ended already.
DistanceResult convexDistance(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                              const DistanceRequest& request, Scratch& scratch, PairCache* cache,
                              double slack = 0, const VertexStart* start = nullptr);

/// Lower bound on the separation of B from the hull of A's placements at X_BA0 and X_BA1, less
/// `growth`; as sweptDistance().
DistanceResult convexSweptDistance(const ConvexView& a, const Pose& X_BA0, const Pose& X_BA1,
                                   double growth, const ConvexView& b,
                                   const DistanceRequest& request, Scratch& scratch,
                                   PairCache* cache, double slack = 0);

}  // namespace leeway::collision
