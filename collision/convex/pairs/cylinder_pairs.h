#pragma once

#include "collision/convex/pairs/simple_pairs.h"

namespace leeway::collision {

// Nearest points of a cylinder and another core. There are three cases:
// - a flat cap, or a box's face, and a corner or rim point of the other: the direction is known;
// - two sides, where the axes are nearest: a closed form;
// - a rim, along which Newton steps lead to the nearest point.
// The functions return false if none of these applies: cores that overlap or touch, steps that do
// not converge. The results are in the world's axes. O(1).

/// The point is the origin of P.
bool nearestOfCylinderAndPoint(const Shape& cylinder, const Pose& X_WC, const Pose& X_WP,
                               Nearest& nearest);

/// The cylinder and the capsule's segment.
bool nearestOfCylinderAndCapsule(const Shape& cylinder, const Pose& X_WC, const Shape& capsule,
                                 const Pose& X_WB, Nearest& nearest);

bool nearestOfCylinders(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        const Goal& goal, Nearest& nearest);

bool nearestOfCylinderAndBox(const Shape& cylinder, const Pose& X_WC, const Shape& box,
                             const Pose& X_WB, const Goal& goal, Nearest& nearest);

}  // namespace leeway::collision
