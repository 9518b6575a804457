#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// The signed separation of two shapes at the poses X_WA and X_WB (any common frame W): an interval
/// that holds the truth, witness points and a normal, all in W.
///
/// Convex pairs: closed forms where there are any, else GJK (Gilbert, Johnson, Keerthi 1988) with
/// both ends of the interval kept and, in contact, an expanding polytope (van den Bergen 2001).
/// O(vertices) a step, fewer where hulls are climbed. Meshes: branch and bound over two
/// hierarchies, up to request.node_limit node pairs.
///
/// Never throws, allocates or loops without end: errors are DistanceStatus::kInvalid. `cache` may
/// be null; one per pair makes the next query of that pair start where this one ended.
DistanceResult distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        const DistanceRequest& request, Scratch& scratch,
                        PairCache* cache = nullptr);

/// As above with a Scratch of its own, which it allocates and frees in every call: .1 to .3 ms,
/// where the query of two simple shapes takes 50 ns; may throw std::bad_alloc. In loops pass a
/// Scratch.
DistanceResult distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        const DistanceRequest& request = {});

/// The tolerance of a request that names none [m]: 1e-9 of the larger body's bounding radius, at
/// most 1e-9 m (half-spaces have no size), but no less than 1e-12 of the larger extent or of the
/// offset between the frames, above rounding; 0 where that is no finite number. O(1).
double defaultTolerance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB);

/// A lower bound on the separation of B from a moving A, seen from B's frame. A goes from X_BA0 to
/// X_BA1; no point of A leaves the chord between its two placements by more than `growth` [m].
///
/// `lower` is the separation of B from the convex hull of A's two placements (for a mesh: of each
/// piece's two placements), minus growth. `upper` bounds the separation at the better of the two
/// placements from above, so that upper <= threshold proves contact at one of them; it is infinite
/// where it would cost extra. Points and normal are in B's frame. Of bodies with an inside (closed
/// meshes) the surfaces are swept: decide containment at one of the placements.
///
/// `request.depth` is ignored: below zero the lower end may be -infinity. kInvalid also for a
/// growth that is negative or NaN. Never throws or allocates; cost as distance().
DistanceResult sweptDistance(const Shape& a, const Pose& X_BA0, const Pose& X_BA1, double growth,
                             const Shape& b, const DistanceRequest& request, Scratch& scratch,
                             PairCache* cache = nullptr);

}  // namespace leeway::collision
