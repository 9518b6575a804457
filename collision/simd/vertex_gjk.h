#pragma once

#include "collision/gjk.h"

namespace leeway::collision {

/// runGjk() for cores with vertices, from a cold start: first along `direction` (any length but 0).
/// Written for speed: steps without branches, in plain arithmetic. Ends with kEnough, kLimit or,
/// where robust steps must go on from `simplex`, kStagnated.
GjkEnd runVertexGjk(Difference<false>& difference, const Vector& direction, Progress& progress,
                    Simplex& simplex);

}  // namespace leeway::collision
