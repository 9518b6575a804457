#pragma once

#include "collision/convex/gjk/gjk.h"

namespace leeway::collision {

/// The points that carried a cache's last distance are vertices of bodies with so many.
inline bool fits(const PairCache& cache, int vertices_a, int vertices_b) {
  if (cache.simplex_count < 1 || cache.simplex_count > 3) return false;
  bool all = true;
  for (int i = 0; i < cache.simplex_count; ++i) {
    const int a = cache.simplex_a[i], b = cache.simplex_b[i];
    all &= a >= 0 && a < vertices_a && b >= 0 && b < vertices_b;
  }
  return all;
}

/// The same for this pair.
bool fits(const Difference<false>& difference, const PairCache& cache);

/// runGjk() for cores with vertices, from the points of `carried` where it is not null (fits() it),
/// else first along `direction` (a unit vector). Written for speed: steps without branches, in
/// plain arithmetic. Ends with kEnough, kLimit, kInside or, where robust steps must go on from
/// `simplex`, kStagnated.
GjkEnd runVertexGjk(Difference<false>& difference, const Vector& direction,
                    const PairCache* carried, Progress& progress, Simplex& simplex);

}  // namespace leeway::collision
