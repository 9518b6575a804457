#pragma once

// Private to collision/: probes, bodies as the boxes of a deforming mesh see them.

#include <Eigen/Core>

#include "collision/deform/bounds/probe_bounds.h"
#include "leeway/collision/pose.h"

namespace leeway::collision {

/// The sum of the magnitudes of the coordinates; 0 for a point that is not finite.
inline double magnitude(const Eigen::Vector3d& p) { return p.allFinite() ? p.lpNorm<1>() : 0; }

/// A box in frame A (which may be infinite) grown by `radius`, placed in frame B; with X_BA1 the
/// hull of both placements. `extent`: sum of the magnitudes of coordinates that boxes in B can have
/// [m]; `slack`: the poses' own error [m].
Probe makeProbe(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double radius,
                const Pose& X_BA0, const Pose* X_BA1, double extent, double slack);

/// A lower bound on the signed separation of the probe and a box [m], as
/// ProbeKernels::childBounds() finds it by boxes. The box may be infinite.
double lowerBound(const Probe& probe, const float* low, const float* high);

}  // namespace leeway::collision
