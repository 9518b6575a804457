#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

namespace leeway::collision {

/// The least and the largest coordinates of a set of points along three axes [m].
struct BoxRange {
  Eigen::Vector3d low, high;
};

/// The number of points must be a multiple of this.
inline constexpr std::size_t kRangeBlock = 8;

/// For each frame, the ranges of all points along its columns; `points` are columns of x, y and z.
/// The same bytes on every instruction set. O(points * frames).
void boxRanges(const std::array<std::span<const double>, 3>& points,
               std::span<const Eigen::Matrix3d> frames, BoxRange* ranges);

}  // namespace leeway::collision
