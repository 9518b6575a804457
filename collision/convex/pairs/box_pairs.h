#pragma once

#include "collision/convex/pairs/simple_pairs.h"

namespace leeway::collision {

/// A point at the origin of S and a box; false inside the box. Everything in the world's axes.
bool nearestOfSphereAndBox(const Pose& X_WS, const Shape& box, const Pose& X_WB, Nearest& nearest);

/// The capsule's segment and a box; false when they touch.
bool nearestOfCapsuleAndBox(const Shape& capsule, const Pose& X_WC, const Shape& box,
                            const Pose& X_WB, Nearest& nearest);

/// Two boxes, by the axis along which they are farthest apart (Gottschalk, Lin and Manocha 1996)
/// when its features meet, else by descending along A's edges; early when that decides the goal. A
/// cache's direction comes first. False when they overlap.
bool nearestOfBoxes(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const Goal& goal, const PairCache* cache, Nearest& nearest);

}  // namespace leeway::collision
