#pragma once

#include "collision/convex/gjk/gjk.h"

namespace leeway::collision {

/// Limit on the moving points of a sweep in lanes: those of a node of a mesh [count].
inline constexpr int kSweptLanes = 32;

/// True for the sweeps that runSweptVertexGjk() accepts: few moving points, and a resting core with
/// vertices.
bool isForSweptLanes(const Difference<true>& difference);

/// runVertexGjk() for such a sweep, starting along `direction` (a unit vector). Offers planes only;
/// the points of `simplex` bound what these can still gain. Ends with kLimit, kInside or
/// kStagnated. kStagnated means that the request is met or that robust steps must continue from
/// `simplex`.
GjkEnd runSweptVertexGjk(Difference<true>& difference, const Vector& direction, Progress& progress,
                         Simplex& simplex);

}  // namespace leeway::collision
