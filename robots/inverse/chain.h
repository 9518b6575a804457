#pragma once

// The joints between a region's frame R and the frame F of the robot, as far as solved variables
// move them; all else is folded into constants.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "leeway/robots/inverse_kinematics.h"

namespace leeway::robots {

/// A joint of the chain: X_PC as in KinematicStep, P the frame of the chain's joint before it.
struct ChainJoint {
  JointType type = JointType::kRevolute;
  int variable = -1;  ///< of the model: the first one
  /// Index of each of its variables among the solved ones; -1: it stays.
  std::array<int, 7> column = {-1, -1, -1, -1, -1, -1, -1};
  double multiplier = 1, offset = 0;
  Eigen::Matrix3d fixed, sine, cosine;
  Eigen::Vector3d translation, u, v;
  Eigen::Vector3d axis;  ///< in C
};

struct Chain {
  std::vector<ChainJoint> joints;  ///< the root's first
  Pose X_PF;                       ///< from the last joint's frame to F; without joints: X_RF
  double reach = 0;                ///< greatest sum of offsets [m]; scales positions to angles
};

/// The chain of `region`. X_WL are the links' poses at the configuration that the variables not
/// solved for keep. `column` has one entry a variable of the model: its index among the solved
/// ones, or -1.
Chain makeChain(const Model& model, const PoseRegion& region, std::span<const Pose> X_WL,
                std::span<const int> column);

/// A column of the Jacobian: how F moves with one variable, in R.
struct Twist {
  int column;
  Eigen::Vector3d linear, angular;
};

/// X_RF at the model's variables `q`. X_RC takes the frame of each joint's child. O(joints).
Pose place(const Chain& chain, const double* q, std::vector<Pose>& X_RC);

/// One twist for each joint and solved variable of it, from what place() gave at q; a variable that
/// drives several joints has several. O(joints).
void findTwists(const Chain& chain, const double* q, const std::vector<Pose>& X_RC,
                const Pose& X_RF, std::vector<Twist>& twists);

}  // namespace leeway::robots
