#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

namespace leeway::collision {

/// The least and largest coordinates of some points along three axes [m].
struct BoxRange {
  Eigen::Vector3d low, high;
};

/// Numbers of points have to be multiples of this.
inline constexpr std::size_t kRangeBlock = 8;

/// For each frame, the ranges along its columns of all points; `points` are their x, y and z. The
/// same bytes on every instruction set. O(points * frames).
void boxRanges(const std::array<std::span<const double>, 3>& points,
               std::span<const Eigen::Matrix3d> frames, BoxRange* ranges);

}  // namespace leeway::collision
