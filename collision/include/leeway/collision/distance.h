#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Returns the signed separation of two shapes at the poses X_WA and X_WB (any common frame W): an
/// interval that contains the exact value, witness points and a normal, all in W.
///
/// Convex pairs use closed forms where they exist. Other pairs use GJK (Gilbert, Johnson, Keerthi
/// 1988), which keeps both ends of the interval, and in contact an expanding polytope (van den
/// Bergen 2001). A step is O(vertices), less for hulls with hill climbing. Meshes use branch and
/// bound over two hierarchies, with at most request.node_limit node pairs.
///
/// Never throws or allocates and always terminates: errors are DistanceStatus::kInvalid. `cache`
/// may be null. With one cache for each pair, the next query of that pair starts where this one
/// ended.
DistanceResult distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        const DistanceRequest& request, Scratch& scratch,
                        PairCache* cache = nullptr);

/// As above, but each call allocates and frees its own Scratch. This takes .1 to .3 ms, while the
/// query of two simple shapes takes 50 ns; it may throw std::bad_alloc. In loops, pass a Scratch.
DistanceResult distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        const DistanceRequest& request = {});

/// The tolerance of a request that does not set one [m]: 1e-9 of the larger body's bounding radius,
/// at most 1e-9 m (half-spaces have no size), but at least 1e-12 of the larger extent or of the
/// offset between the frames, which is above rounding. 0 where that is not a finite number. O(1).
double defaultTolerance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB);

/// A lower bound on the separation of B from a moving A, seen from B's frame. A goes from X_BA0 to
/// X_BA1; no point of A leaves the chord between its two placements by more than `growth` [m].
///
/// `lower` is the separation of B from the convex hull of A's two placements (for a mesh: of each
/// piece's two placements), minus growth. `upper` is an upper bound on the separation at the better
/// of the two placements, so upper <= threshold proves contact at one of them; it is infinite where
/// it would cost extra. Points and normal are in B's frame. Only the surfaces of bodies with an
/// inside (closed meshes) are swept: test containment separately, at one of the placements.
///
/// `request.depth` is ignored: below zero the lower end may be -infinity. kInvalid also for a
/// growth that is negative or NaN. Never throws or allocates; cost as distance().
DistanceResult sweptDistance(const Shape& a, const Pose& X_BA0, const Pose& X_BA1, double growth,
                             const Shape& b, const DistanceRequest& request, Scratch& scratch,
                             PairCache* cache = nullptr);

}  // namespace leeway::collision
