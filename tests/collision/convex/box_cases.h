#pragma once

#include <cmath>

#include "collision/mesh/box_tree.h"
#include "tests/support/mesh_cases.h"

namespace leeway::collision::testing {

/// A box within `reach` [m] of the origin, with half extents of up to `size` [m]; some flat or
/// thin.
inline OrientedBox randomBox(Random& random, double reach, double size) {
  const Pose pose = random.pose(reach);
  OrientedBox box{};
  for (int k = 0; k < 3; ++k) {
    box.center[k] = static_cast<float>(pose.translation[k]);
    box.half[k] = random.below(4) == 0
                      ? 0.0F
                      : static_cast<float>(size * std::pow(10, random.uniform(-3, 0)));
    for (int i = 0; i < 3; ++i) box.axis[k][i] = static_cast<float>(pose.rotation(i, k));
  }
  return box;
}

inline void setColumn(BoxNode& node, int column, const OrientedBox& box) {
  for (int k = 0; k < 3; ++k) {
    node.center[k][column] = box.center[k];
    node.half[k][column] = box.half[k];
    for (int i = 0; i < 3; ++i) node.axis[k][i][column] = box.axis[k][i];
  }
}

}  // namespace leeway::collision::testing
