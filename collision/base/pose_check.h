#pragma once

#include <cmath>
#include <cstdint>

#include "collision/base/tolerances.h"
#include "leeway/collision/pose.h"

namespace leeway::collision {

/// Two doubles with the same operation on both: one lane for each body. (A vector extension of gcc
/// and clang. Lanes are rounded like single doubles, so that targets without such registers give
/// the same results.)
using BodyLanes = double __attribute__((vector_size(16)));

inline __attribute__((always_inline)) BodyLanes magnitude(BodyLanes x) {
  using Bits = std::int64_t __attribute__((vector_size(16)));
  constexpr std::int64_t kAllButSign = 0x7fffffffffffffff;
  return reinterpret_cast<BodyLanes>(reinterpret_cast<Bits>(x) & Bits{kAllButSign, kAllButSign});
}

/// x > y in either lane, in one branch, because which lane it is is unpredictable.
inline __attribute__((always_inline)) bool eitherIsGreater(BodyLanes x, BodyLanes y) {
  const auto greater = x > y;
  return (greater[0] | greater[1]) != 0;
}

/// How far the matrices of two poses are from rotations: see RelativePose (gjk/convex_view.h).
struct PoseCheck {
  /// Both departures are at most kRotationTolerance; false if an entry is not finite.
  bool rotations = false;
  double departure = 0;  ///< an upper bound of their sum, at most sqrt(2) times it
};

/// R^T R - 1 of two matrices, one lane each: the diagonal and the other entries. NaN or infinite if
/// an entry of the matrix is.
struct Departures {
  BodyLanes aa, bb, cc, ab, bc, ca;
};
inline __attribute__((always_inline)) Departures departuresOf(const Eigen::Matrix3d& R,
                                                              const Eigen::Matrix3d& S) {
  const auto entry = [&](int i, int j) __attribute__((always_inline)) {
    return BodyLanes{R(i, j), S(i, j)};
  };
  const BodyLanes a0 = entry(0, 0), a1 = entry(1, 0), a2 = entry(2, 0);
  const BodyLanes b0 = entry(0, 1), b1 = entry(1, 1), b2 = entry(2, 1);
  const BodyLanes c0 = entry(0, 2), c1 = entry(1, 2), c2 = entry(2, 2);
  const BodyLanes one = {1, 1};
  return {a0 * a0 + a1 * a1 + a2 * a2 - one, b0 * b0 + b1 * b1 + b2 * b2 - one,
          c0 * c0 + c1 * c1 + c2 * c2 - one, a0 * b0 + a1 * b1 + a2 * b2,
          b0 * c0 + b1 * c1 + b2 * c2,       c0 * a0 + c1 * a1 + c2 * a2};
}

/// Every query starts with this check: O(1), branch-free. It ignores the translations.
inline __attribute__((always_inline)) PoseCheck checkRotations(const Eigen::Matrix3d& R,
                                                               const Eigen::Matrix3d& S) {
  const Departures d = departuresOf(R, S);
  // Squared Frobenius norms.
  const BodyLanes mixed = d.ab * d.ab + d.bc * d.bc + d.ca * d.ca;
  const BodyLanes departure = d.aa * d.aa + d.bb * d.bb + d.cc * d.cc + (mixed + mixed);
  constexpr double kLimit = kRotationTolerance * kRotationTolerance;
  // sqrt(x) + sqrt(y) <= sqrt(2 (x + y)) saves a root. The comparisons fail for NaN and infinity.
  return {departure[0] <= kLimit && departure[1] <= kLimit,
          std::sqrt(2 * (departure[0] + departure[1]))};
}

/// An upper bound on
/// R^T R - 1
///  (Frobenius) of one matrix; the norm is computed to within 9 units of roundoff. The distance of
///  a matrix from the nearest rotation is half of that, times (1 + itself).
inline double departureOf(const Eigen::Matrix3d& R) {
  return 0.5 * checkRotations(R, R).departure + 16 * kUnitRoundoff;
}

/// Whether queries accept X as a pose: finite, and orthogonal within kRotationTolerance.
inline bool isPose(const Pose& X) {
  return X.translation.allFinite() && checkRotations(X.rotation, X.rotation).rotations;
}

/// checkRotations() with sums of magnitudes, which are no smaller than Frobenius norms. It needs
/// fewer operations and no root, but may reject a matrix near the tolerance.
inline __attribute__((always_inline)) PoseCheck checkRotationsQuickly(const Eigen::Matrix3d& R,
                                                                      const Eigen::Matrix3d& S) {
  const Departures d = departuresOf(R, S);
  const BodyLanes mixed = magnitude(d.ab) + magnitude(d.bc) + magnitude(d.ca);
  const BodyLanes departure = magnitude(d.aa) + magnitude(d.bb) + magnitude(d.cc) + (mixed + mixed);
  const double sum = departure[0] + departure[1];
  return {sum <= kRotationTolerance, sum};
}

}  // namespace leeway::collision
