#pragma once

#include <cmath>

#include "leeway/collision/pose.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {

/// Two numbers side by side, the same operation on both: a lane for each body. (Every compiler that
/// we build with has these; they are rounded like single doubles, so that results are the same
/// where they are not fast.)
typedef double BodyLanes __attribute__((vector_size(16)));

/// How far the matrices of two poses are from rotations: see RelativePose (convex.h).
struct PoseCheck {
  /// Both departures are at most kRotationTolerance; false when an entry is not finite.
  bool rotations = false;
  double departure = 0;  ///< the sum of both, or a little more
};

/// O(1), without a branch: every query starts with it. Translations are not looked at.
inline __attribute__((always_inline)) PoseCheck checkRotations(const Eigen::Matrix3d& R,
                                                               const Eigen::Matrix3d& S) {
  using Lanes = BodyLanes;
  const auto entry = [&](int i, int j) __attribute__((always_inline)) {
    return Lanes{R(i, j), S(i, j)};
  };
  const Lanes a0 = entry(0, 0), a1 = entry(1, 0), a2 = entry(2, 0);
  const Lanes b0 = entry(0, 1), b1 = entry(1, 1), b2 = entry(2, 1);
  const Lanes c0 = entry(0, 2), c1 = entry(1, 2), c2 = entry(2, 2);
  const Lanes one = {1, 1};
  // Squared Frobenius norms of R^T R - 1. NaN or infinite when an entry is.
  const Lanes aa = a0 * a0 + a1 * a1 + a2 * a2 - one;
  const Lanes bb = b0 * b0 + b1 * b1 + b2 * b2 - one;
  const Lanes cc = c0 * c0 + c1 * c1 + c2 * c2 - one;
  const Lanes ab = a0 * b0 + a1 * b1 + a2 * b2;
  const Lanes bc = b0 * c0 + b1 * c1 + b2 * c2;
  const Lanes ca = c0 * a0 + c1 * a1 + c2 * a2;
  const Lanes mixed = ab * ab + bc * bc + ca * ca;
  const Lanes departure = aa * aa + bb * bb + cc * cc + (mixed + mixed);
  constexpr double kLimit = kRotationTolerance * kRotationTolerance;
  // sqrt(x) + sqrt(y) <= sqrt(2 (x + y)), at one root less. Comparisons are written so that NaN and
  // infinity fail.
  return {departure[0] <= kLimit && departure[1] <= kLimit,
          std::sqrt(2 * (departure[0] + departure[1]))};
}

}  // namespace leeway::collision
