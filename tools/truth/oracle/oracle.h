#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::oracle {

/// Where the truth lies: lower <= signed separation <= upper.
struct Truth {
  double lower, upper;  // [m]
  /// The two bounds are meant to meet (within rounding, or what a curve of closest points leaves).
  /// False for an overlap with a mesh, where they only enclose the smallest separating translation.
  bool has_value;
};

/// The signed separation of any two shapes, in quadruple precision and without any code of the
/// engine. Slow: up to seconds. Half-space with half-space: (-inf, inf), no value.
Truth signedSeparation(const collision::Shape& a, const collision::Pose& X_WA,
                       const collision::Shape& b, const collision::Pose& X_WB);

}  // namespace leeway::oracle
