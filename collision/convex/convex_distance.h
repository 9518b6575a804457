#pragma once

// Private to collision/: distance between two convex pieces, for the dispatcher, meshes and scenes.

#include "collision/convex/gjk/convex_view.h"
#include "leeway/collision/query.h"

namespace leeway::collision {

struct VertexStart;  // convex/hull_pairs.h

/// Signed separation of two convex pieces; points and normal are in B. X_BA is used as an exact
/// affine map. `slack` [m] bounds its error and widens both ends before they are compared with
/// threshold and tolerance. cache may be null. `start`: the end of a previous search on the
/// vertices of this pair. Stages in the order of cost: closed forms, GJK, EPA, search over
/// directions.
DistanceResult convexDistance(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                              const DistanceRequest& request, Scratch& scratch, PairCache* cache,
                              double slack = 0, const VertexStart* start = nullptr);

/// Lower bound on the separation of B from the hull of A's placements at X_BA0 and X_BA1, minus
/// `growth` [m]; see sweptDistance(). Arguments as for convexDistance().
DistanceResult convexSweptDistance(const ConvexView& a, const Pose& X_BA0, const Pose& X_BA1,
                                   double growth, const ConvexView& b,
                                   const DistanceRequest& request, Scratch& scratch,
                                   PairCache* cache, double slack = 0);

}  // namespace leeway::collision
