#pragma once

#include "collision/gjk.h"

namespace leeway::collision {

/// Names of the two vertices that a point of the difference is made of.
struct VertexNames {
  int a, b;
};

/// The points that carried the last distance.
struct VertexCarrier {
  int count = 0;
  VertexNames names[3];
};

/// runGjk() for cores with vertices, first along `direction` (any length but 0) or, where a cache
/// is given that fits, from the points that carried the last distance. Written for speed: steps
/// without branches, in plain arithmetic. Ends with kEnough, kLimit or, where robust steps must go
/// on from `simplex`, kStagnated.
GjkEnd runVertexGjk(Difference<false>& difference, const Vector& direction, const PairCache* cache,
                    Progress& progress, Simplex& simplex);

}  // namespace leeway::collision
