#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

enum class Containment : unsigned char {
  kNo,         ///< no component of either body lies inside a closed component of the other
  kYes,        ///< a point of one body is proven to lie inside a closed component of the other
  kUndecided,  ///< rounding or a limit left the question open: treat it as kYes
};

/// Whether a component of A lies inside a closed component of B, or the reverse, at these poses.
/// One point of each component is tested. This decides containment where the surfaces are apart;
/// where they cross, both kYes and kNo are possible. Only closed components of meshes are tested
/// for an inside, because distance() and sweptDistance() already handle the inside of convex
/// shapes. If neither body has such a component, the answer is kNo at once. A half-space lies
/// inside nothing. Never throws or allocates. Usually O(components * sqrt(triangles)).
Containment contains(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                     Scratch& scratch);

}  // namespace leeway::collision
