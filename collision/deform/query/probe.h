#pragma once

// Private to collision/: probes, the form in which bodies are compared with the boxes of a
// deforming mesh.

#include <Eigen/Core>

#include "collision/deform/bounds/probe_bounds.h"
#include "leeway/collision/pose.h"

namespace leeway::collision {

/// The sum of the magnitudes of the coordinates; 0 if the point is not finite.
inline double magnitude(const Eigen::Vector3d& p) { return p.allFinite() ? p.lpNorm<1>() : 0; }

/// A box in frame A (which may be infinite) grown by `radius`, placed in frame B; with X_BA1 the
/// hull of both placements. `extent`: limit on the sum of the magnitudes of coordinates of boxes in
/// B [m]; `slack`: the poses' own error [m].
Probe makeProbe(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double radius,
                const Pose& X_BA0, const Pose* X_BA1, double extent, double slack);

/// A lower bound on the signed separation of the probe and a box [m], as
/// ProbeKernels::childBounds() computes it by boxes. The box may be infinite.
double lowerBound(const Probe& probe, const float* low, const float* high);

}  // namespace leeway::collision
