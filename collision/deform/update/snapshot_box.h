#pragma once

// Private to collision/: boxes of a snapshot.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "collision/base/tolerances.h"
#include "collision/deform/snapshot.h"

namespace leeway::collision {

inline void reserveBoxes(DeformableSnapshotImpl& snapshot, std::int32_t nodes) {
  const auto count = static_cast<std::size_t>(nodes);
  if (snapshot.boxes.size() < count) snapshot.boxes.resize(count);
}

/// Sets the snapshot's box to the union of the boxes of the root's children.
inline void setBox(DeformableSnapshotImpl& snapshot, const WideBox& root) {
  for (int k = 0; k < 3; ++k) {
    snapshot.low[k] = static_cast<double>(*std::min_element(root.low[k], root.low[k] + kWidth));
    snapshot.high[k] = static_cast<double>(*std::max_element(root.high[k], root.high[k] + kWidth));
  }
}

/// Whether the snapshot's box is within the limit; false for NaN.
inline bool isWithin(const DeformableSnapshotImpl& snapshot, double limit) {
  return (snapshot.low.array() >= -limit).all() && (snapshot.high.array() <= limit).all();
}

/// Whether all vertices may be within the limit. Boxes are rounded outwards, so the limit is a
/// little larger.
inline bool isWithinLimits(const DeformableSnapshotImpl& snapshot) {
  return isWithin(snapshot, 1.01 * kLargestSize);
}

/// Half the surface area of a box with these sides.
inline double halfArea(const Eigen::Vector3d& side) {
  return side.x() * side.y() + side.y() * side.z() + side.z() * side.x();
}

/// The sides of the box in a column that is not empty.
inline Eigen::Vector3d sidesOf(const WideBox& box, std::int32_t column) {
  Eigen::Vector3d side;
  for (int k = 0; k < 3; ++k)
    side[k] = static_cast<double>(box.high[k][column]) - static_cast<double>(box.low[k][column]);
  return side;
}

}  // namespace leeway::collision
