#pragma once

#include "collision/convex/gjk/gjk.h"

namespace leeway::collision {

/// Points that move are followed side by side up to so many: what nodes of meshes have [count].
inline constexpr int kSweptLanes = 32;

/// Whether runSweptVertexGjk() takes a sweep: few points that move, and vertices that stand.
bool isForSweptLanes(const Difference<true>& difference);

/// runGjk() for such a sweep, first along `direction` (a unit vector), as runVertexGjk() does it.
/// Offers planes alone: the points of `simplex` say how good they are. Ends with kLimit, kInside
/// or, where the request is met or robust steps must go on from `simplex`, kStagnated.
GjkEnd runSweptVertexGjk(Difference<true>& difference, const Vector& direction, Progress& progress,
                         Simplex& simplex);

}  // namespace leeway::collision
