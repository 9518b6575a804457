#pragma once

#include "collision/convex/gjk/gjk.h"

namespace leeway::collision {

/// Most moving points that a sweep handles in lanes: those of a node of a mesh [count].
inline constexpr int kSweptLanes = 32;

/// True for the sweeps that runSweptVertexGjk() takes: few moving points, and a resting core with
/// vertices.
bool isForSweptLanes(const Difference<true>& difference);

/// runVertexGjk() for such a sweep, first along `direction` (a unit vector). Offers planes only;
/// the points of `simplex` bound what these can still gain. Ends with kLimit, kInside or, where the
/// request is met or robust steps must take over from `simplex`, kStagnated.
GjkEnd runSweptVertexGjk(Difference<true>& difference, const Vector& direction, Progress& progress,
                         Simplex& simplex);

}  // namespace leeway::collision
