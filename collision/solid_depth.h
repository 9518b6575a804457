#pragma once

#include "leeway/collision/distance.h"

namespace leeway::collision {

struct SolidDepth {
  double depth = 0;                                   ///< [m]; 0 when nothing is found
  Eigen::Vector3d way_out = Eigen::Vector3d::Zero();  ///< of B, in W: worth a try; any length
};

/// A length that every translation that separates two overlapping solids must have [m]; 0 when
/// nothing is found. A ball in A and a ball in B around the same point stay apart only when moved
/// by the sum of their radii: so for any point inside both, the sum of its distances from the two
/// surfaces is one. The search starts at the given points (in W) and climbs; at most
/// kDeepestPointSteps points are looked at.
SolidDepth solidDepth(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                      const Eigen::Vector3d* starts, int count, Scratch& scratch);

}  // namespace leeway::collision
