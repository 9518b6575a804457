#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// The tolerance of a request that names none [m]: 1e-9 of the larger body's bounding radius, at
/// most 1e-9 m (half-spaces have no size), but no less than 1e-12 of the larger extent or of the
/// offset between the frames, above rounding; 0 where that is no finite number. O(1).
double defaultTolerance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB);

/// The signed separation of two shapes at the poses X_WA, X_WB (any common frame W).
/// Never throws, allocates or loops without end. `cache` may be null. Convex pairs: closed forms
/// where there are some, else GJK (Gilbert, Johnson, Keerthi 1988) with both ends kept and, in
/// contact, an expanding polytope (van den Bergen 2001); O(vertices) a step at the most, fewer
/// where hulls are climbed. Meshes: branch and bound over two hierarchies, up to request.node_limit
/// node pairs.
DistanceResult distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        const DistanceRequest& request, Scratch& scratch,
                        PairCache* cache = nullptr);

/// A lower bound on the separation of B from A while A moves, seen from B's frame, from X_BA0 to
/// X_BA1 so that no point of A leaves the chord between its two placements by more than `growth`
/// [m]: the separation of B and the convex hull of A's two placements (for a mesh: of each piece's
/// two placements), minus growth. `upper` of the returned interval bounds the separation at the
/// better of the two placements from above, so that upper <= threshold proves contact at one of
/// them (only when it can be had at no extra cost; otherwise it is infinite). For bodies with an
/// inside (closed meshes), surfaces are swept: containment must be decided by the caller at one of
/// the placements. `request.depth` is ignored: below zero the lower end may be -infinity. kInvalid
/// also for a growth that is negative or NaN. Never throws or allocates; cost as distance().
DistanceResult sweptDistance(const Shape& a, const Pose& X_BA0, const Pose& X_BA1, double growth,
                             const Shape& b, const DistanceRequest& request, Scratch& scratch,
                             PairCache* cache = nullptr);

}  // namespace leeway::collision
