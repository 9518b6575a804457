#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::oracle {

/// lower <= signed separation <= upper.
struct Truth {
  double lower, upper;  // [m]
  /// True if the bounds meet (up to rounding, or the error that a curve of closest points leaves).
  /// False for overlaps with a mesh, for which they only enclose the smallest separating
  /// translation.
  bool has_value;
};

/// Sufficient bounds for convexSeparation() [m].
struct Enough {
  double lower, upper;
};

/// The signed separation of any two shapes, in quadruple precision and without the engine's code.
/// Slow: up to seconds. Half-space with half-space: (-inf, inf), no value.
Truth signedSeparation(const collision::Shape& a, const collision::Pose& X_WA,
                       const collision::Shape& b, const collision::Pose& X_WB);

/// The same, but faster for two convex bodies: the search ends when it has proven the separation to
/// be within `enough`, the answer that is being checked. A wrong answer is never proven, and the
/// bounds that contradict it are those above.
Truth convexSeparation(const collision::Shape& a, const collision::Pose& X_WA,
                       const collision::Shape& b, const collision::Pose& X_WB,
                       const Enough& enough);

}  // namespace leeway::oracle
