#pragma once

#include <span>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Poses of all links in the world at the configuration q (one number a variable; mimic joints
/// follow): X_WL has model.links.size() entries, in link order. One pass, parents before children;
/// O(links), throws and allocates nothing. Rounding moves no entry by more than
/// kinematicsRounding() at its distance from the world's origin.
void forwardKinematics(const Model& model, std::span<const double> q, std::span<Pose> X_WL);

/// forwardKinematics() of `count` configurations, to the bit: q row by row, X_WL[i * links + l].
void forwardKinematicsBatch(const Model& model, std::span<const double> q, int count,
                            std::span<Pose> X_WL);

/// Replaces `chain` by the links and all their ancestors, parents before children. -1, which stands
/// for the world, is left out. Allocates where `chain` has no room for all. O(depth log depth).
void findChain(const Model& model, std::span<const int> links, std::vector<int>& chain);

/// forwardKinematics() of some links alone, to the bit: of a chain from findChain(), or of its
/// links from one on where X_WL has those before it. Other entries stay as they are. O(chain).
void chainKinematics(const Model& model, std::span<const double> q, std::span<const int> chain,
                     std::span<Pose> X_WL);

/// Bound on how far rounding in forwardKinematics() moves a point within `reach` of the world's
/// origin [m]. O(joints). Derived in kinematics.cc.
double kinematicsRounding(const Model& model, double reach);

}  // namespace leeway::robots
