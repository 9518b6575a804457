#pragma once

#include "collision/gjk.h"

namespace leeway::collision {

/// The points that carried a cache's last distance are vertices of this pair.
bool fits(const Difference<false>& difference, const PairCache& cache);

/// runGjk() for cores with vertices, from the points of `carried` where it is not null (fits() it),
/// else first along `direction` (a unit vector). Written for speed: steps without branches, in
/// plain arithmetic. Ends with kEnough, kLimit, kInside or, where robust steps must go on from
/// `simplex`, kStagnated.
GjkEnd runVertexGjk(Difference<false>& difference, const Vector& direction,
                    const PairCache* carried, Progress& progress, Simplex& simplex);

}  // namespace leeway::collision
