#pragma once

#include "collision/gjk.h"

namespace leeway::collision {

/// Names of the two vertices that a point of the difference is made of.
struct VertexNames {
  int a, b;
};

/// The points that carry the nearest one, with their weights; without weight, they do not.
struct VertexCarrier {
  VertexNames names[3];
  double weight[3];
};

/// runGjk() for cores with vertices, from a cold start: first along `direction` (any length but 0).
/// Written for speed: steps without branches, in plain arithmetic. Ends with kEnough, kLimit or,
/// where robust steps must go on from `simplex`, kStagnated.
GjkEnd runVertexGjk(Difference<false>& difference, const Vector& direction, Progress& progress,
                    Simplex& simplex);

}  // namespace leeway::collision
