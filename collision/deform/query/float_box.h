#pragma once

// Private to collision/: conversions of FloatBox.

#include <Eigen/Core>

#include "collision/base/rounding.h"
#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// Rounds a box outwards.
inline FloatBox floatBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  FloatBox box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = roundedDown(low[k]);
    box.high[k] = roundedUpToFloat(high[k]);
  }
  return box;
}

/// The box in one column.
inline FloatBox floatBox(const WideBox& box, int column) {
  FloatBox one;
  for (int k = 0; k < 3; ++k) {
    one.low[k] = box.low[k][column];
    one.high[k] = box.high[k][column];
  }
  return one;
}

inline Eigen::Vector3d lowOf(const FloatBox& box) {
  return {static_cast<double>(box.low[0]), static_cast<double>(box.low[1]),
          static_cast<double>(box.low[2])};
}
inline Eigen::Vector3d highOf(const FloatBox& box) {
  return {static_cast<double>(box.high[0]), static_cast<double>(box.high[1]),
          static_cast<double>(box.high[2])};
}

}  // namespace leeway::collision
