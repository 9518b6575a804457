#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::oracle {

/// lower <= signed separation <= upper.
struct Truth {
  double lower, upper;  // [m]
  /// True: the bounds meet (within rounding, or what a curve of closest points leaves). False for
  /// overlaps with a mesh: they only enclose the smallest separating translation.
  bool has_value;
};

/// Bounds of convexSeparation() that suffice [m].
struct Enough {
  double lower, upper;
};

/// The signed separation of any two shapes, in quadruple precision and without the engine's code.
/// Slow: up to seconds. Half-space with half-space: (-inf, inf), no value.
Truth signedSeparation(const collision::Shape& a, const collision::Pose& X_WA,
                       const collision::Shape& b, const collision::Pose& X_WB);

/// The same, and of two convex bodies sooner: the search ends where it has proven the separation
/// within `enough`, the answer that is to be judged. A wrong answer is never proven so, and the
/// bounds that contradict it are those above.
Truth convexSeparation(const collision::Shape& a, const collision::Pose& X_WA,
                       const collision::Shape& b, const collision::Pose& X_WB,
                       const Enough& enough);

}  // namespace leeway::oracle
