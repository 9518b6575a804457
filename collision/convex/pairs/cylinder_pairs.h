#pragma once

#include "collision/convex/pairs/simple_pairs.h"

namespace leeway::collision {

// A is a cylinder. What can be nearest of two such bodies is one of: a flat cap or a box's face and
// a corner or rim point of the other (directions that are known); two sides, where their axes are
// nearest (a closed form); or a rim, along which Newton's steps lead to the nearest point. False
// where none of these does: cores that overlap or touch, steps that do not converge.

/// A point at the origin of P. Everything in the world's axes.
bool nearestOfCylinderAndPoint(const Shape& cylinder, const Pose& X_WC, const Pose& X_WP,
                               Nearest& nearest);

/// The capsule's segment.
bool nearestOfCylinderAndCapsule(const Shape& cylinder, const Pose& X_WC, const Shape& capsule,
                                 const Pose& X_WB, Nearest& nearest);

bool nearestOfCylinders(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        const Goal& goal, Nearest& nearest);

bool nearestOfCylinderAndBox(const Shape& cylinder, const Pose& X_WC, const Shape& box,
                             const Pose& X_WB, const Goal& goal, Nearest& nearest);

}  // namespace leeway::collision
