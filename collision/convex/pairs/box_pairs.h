#pragma once

#include "collision/convex/pairs/simple_pairs.h"

namespace leeway::collision {

// Nearest points of a box and another core, in the world's axes. O(1).

/// The origin of S and a box; false if it is inside the box.
bool nearestOfSphereAndBox(const Pose& X_WS, const Shape& box, const Pose& X_WB, Nearest& nearest);

/// The capsule's segment and a box; false if they touch.
bool nearestOfCapsuleAndBox(const Shape& capsule, const Pose& X_WC, const Shape& box,
                            const Pose& X_WB, Nearest& nearest);

/// Two boxes, by the separating axis with the widest gap (Gottschalk, Lin and Manocha 1996) if the
/// features on that axis hold the nearest points, otherwise by a descent along A's edges. Ends
/// early when the goal is decided. The cached direction is tried first. False if they overlap.
bool nearestOfBoxes(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const Goal& goal, const PairCache* cache, Nearest& nearest);

}  // namespace leeway::collision
