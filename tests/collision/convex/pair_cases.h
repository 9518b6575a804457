#pragma once

// Shared by tests of fast paths for pairs of shapes, whose slow twin is generalDistance().

#include <string>

#include "collision/convex/pairs/simple_pairs.h"
#include "leeway/collision/distance.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision::testing {

/// A request for the parts of distance(), which need an explicit tolerance.
inline DistanceRequest nanometre() {
  DistanceRequest request;
  request.tolerance = 1e-9;
  return request;
}

struct Pair {
  Shape a, b;
  Pose X_WA, X_WB;
  /// Sum of both bodies' extents [m].
  double size() const { return a.extent() + b.extent(); }
  std::string replay() const {
    return oracle::replay(a) + " at " + oracle::replay(X_WA) + " with " + oracle::replay(b) +
           " at " + oracle::replay(X_WB);
  }
};

/// Moves B along the normal until the bodies are about `gap` [m] apart.
inline void moveApart(Pair& pair, double gap, Scratch& scratch) {
  const DistanceResult r =
      generalDistance(pair.a, pair.X_WA, pair.b, pair.X_WB, nanometre(), scratch, nullptr);
  pair.X_WB.translation += (gap - r.distance.upper) * r.normal;
}

/// How far p is outside a shape [m]: its distance from a sphere of radius 0.
inline double outside(const Shape& shape, const Pose& X_WS, const Eigen::Vector3d& p_W,
                      Scratch& scratch) {
  return generalDistance(Shape::sphere(0), {Eigen::Matrix3d::Identity(), p_W}, shape, X_WS,
                         nanometre(), scratch, nullptr)
      .distance.lower;
}

}  // namespace leeway::collision::testing
