#pragma once

// Private to collision/: the sizes that shapes may have.

#include <Eigen/Core>
#include <span>

namespace leeway::collision {

/// Throws InvalidShape unless the largest of a shape's sizes [m] is 0 (a point) or from
/// kSmallestSize to kLargestSize. `what` starts the message, for example "sphere: radius".
void requireExtent(double largest, const char* what);

/// Throws InvalidShape if a coordinate [m] is not finite or exceeds kLargestSize in magnitude, and
/// if the longest side of the box around all points is neither 0 nor at least kSmallestSize.
/// `shape` and `point` name them, for example "mesh" and "vertex". O(n).
void requireSizes(std::span<const Eigen::Vector3d> points, const char* shape, const char* point);

}  // namespace leeway::collision
