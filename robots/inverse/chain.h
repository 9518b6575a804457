#pragma once

// The joints between a region's frame R and the frame F of the robot that solved variables move;
// all other transformations are folded into constants.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "leeway/robots/inverse_kinematics.h"

namespace leeway::robots {

/// A joint of the chain: X_PC as in KinematicStep, where P is the frame of the previous joint of
/// the chain.
struct ChainJoint {
  JointType type = JointType::kRevolute;
  int variable = -1;  ///< of the model: the first one
  /// Index of each of its variables among the solved ones; -1: the variable is constant.
  std::array<int, 7> column = {-1, -1, -1, -1, -1, -1, -1};
  double multiplier = 1, offset = 0;
  Eigen::Matrix3d fixed, sine, cosine;
  Eigen::Vector3d translation, u, v;
  Eigen::Vector3d axis;  ///< in C
};

struct Chain {
  std::vector<ChainJoint> joints;  ///< ordered from the root
  Pose X_PF;                       ///< from the last joint's frame to F; without joints: X_RF
  double reach = 0;                ///< greatest sum of offsets [m]; it scales positions to angles
};

/// Makes the chain of `region`; with a base, from the world, and R is then the world. X_WL are the
/// links' poses at the configuration that gives the values of all variables that are not solved.
/// `column` has one entry for each variable of the model: its index among the solved ones, or -1.
Chain makeChain(const Model& model, const PoseRegion& region, std::span<const Pose> X_WL,
                std::span<const int> column);

/// Makes the chain from the world to R, of a region with a base: its F is R.
Chain makeBaseChain(const Model& model, const PoseRegion& region, std::span<const Pose> X_WL,
                    std::span<const int> column);

/// A column of the Jacobian: the motion of F with one variable, in R.
struct Twist {
  int column;
  Eigen::Vector3d linear, angular;
};

/// Computes X_RF at the model's variables `q`. X_RC receives the frame of each joint's child.
/// O(joints).
Pose place(const Chain& chain, const double* q, std::vector<Pose>& X_RC);

/// Computes one twist for each joint and each of its solved variables, from the result of place()
/// at q; a variable that drives several joints has several twists. O(joints).
void findTwists(const Chain& chain, const double* q, const std::vector<Pose>& X_RC,
                const Pose& X_RF, std::vector<Twist>& twists);

}  // namespace leeway::robots
