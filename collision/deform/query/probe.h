#pragma once

// Private to collision/: bodies as the boxes of a deforming mesh see them.

#include <Eigen/Core>

#include "collision/deform/tree/refit.h"
#include "leeway/collision/pose.h"

namespace leeway::collision {

/// A box (in frame A, may be infinite) grown by `radius`, placed in frame B once or, swept, twice
/// (the probe then holds the hull of both placements). `extent` is the sum of the magnitudes of
/// coordinates that the boxes to be met can have, `slack` [m] the poses' own error.
Probe makeProbe(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double radius,
                const Pose& X_BA0, const Pose* X_BA1, double extent, double slack);

/// The same bound as DeformKernels::childBounds() by boxes, for one. Boxes may be infinite.
double lowerBound(const Probe& probe, const float* low, const float* high);

}  // namespace leeway::collision
