#pragma once

#include "collision/convex/gjk/gjk.h"

namespace leeway::collision {

/// True if the vertices in a cache exist in bodies with these numbers of vertices.
inline bool fits(const PairCache& cache, int vertices_a, int vertices_b) {
  if (cache.simplex_count < 1 || cache.simplex_count > 3) return false;
  bool all = true;
  for (int i = 0; i < cache.simplex_count; ++i) {
    const int a = cache.simplex_a[i], b = cache.simplex_b[i];
    all &= a >= 0 && a < vertices_a && b >= 0 && b < vertices_b;
  }
  return all;
}

/// True when they exist in this pair.
bool fits(const Difference<false>& difference, const PairCache& cache);

/// runGjk() for cores with vertices, written for speed: branch-free steps in plain arithmetic.
/// Starts from the points of `carried` if that is not null (and fits()), otherwise along
/// `direction` (a unit vector). Ends with kEnough, kLimit, kInside or, if robust steps must
/// continue from `simplex`, kStagnated.
GjkEnd runVertexGjk(Difference<false>& difference, const Vector& direction,
                    const PairCache* carried, Progress& progress, Simplex& simplex);

}  // namespace leeway::collision
