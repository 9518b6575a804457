#pragma once

#include <span>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Poses of all links in the world at the configuration q (one number a variable; mimic joints
/// follow). X_WL has model.links.size() entries, in link order. One parent-before-child pass:
/// O(links); never throws, allocates nothing. Each entry departs from the exact pose of the given
/// numbers by at most kinematicsRounding() at the pose's own distance from the world's origin.
void forwardKinematics(const Model& model, std::span<const double> q, std::span<Pose> X_WL);

/// The same for `count` configurations: q row by row, X_WL[i * links + l]. Bit for bit the same
/// numbers.
void forwardKinematicsBatch(const Model& model, std::span<const double> q, int count,
                            std::span<Pose> X_WL);

/// A bound on how far rounding moves any point within `reach` of the world's origin in
/// forwardKinematics [m]. O(joints); derived where it is defined.
double kinematicsRounding(const Model& model, double reach);

}  // namespace leeway::robots
