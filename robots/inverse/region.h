#pragma once

// How far a frame is outside of a PoseRegion, with what a solver needs to bring it in.

#include <Eigen/Core>
#include <optional>
#include <string>

#include "leeway/robots/inverse_kinematics.h"

namespace leeway::robots {

/// A region with what its searches reuse.
struct PreparedRegion {
  explicit PreparedRegion(const PoseRegion& region);

  std::array<std::pair<double, double>, 3> position, rpy;
  bool exact_turn = false;  // one rotation
  bool any_turn = false;    // all rotations
  Eigen::Matrix3d target;   // of exact_turn
};

/// In the region's frame R: the frame's place minus the nearest allowed one.
struct RegionError {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< rotation vector
  /// Coordinates inside their range, where a move costs nothing.
  std::array<bool, 3> free_position = {false, false, false};
  /// Orthonormal axes about which a small turn costs nothing.
  int free_turns = 0;
  std::array<Eigen::Vector3d, 3> free_axis;
};

/// Returns the fault of a region, with the accepted values: a link that the model does not have, a
/// frame that is not rigid, a range whose ends are exchanged or not finite, a tolerance below
/// kLeastPoseTolerance. Nothing for a region that makes sense.
std::optional<std::string> regionFault(const Model& model, const PoseRegion& region);

RegionError regionError(const PreparedRegion& region, const Pose& X_RF);

/// The rotation vector of R, its length in [0, pi].
Eigen::Vector3d rotationVector(const Eigen::Matrix3d& R);

/// The angle equal to `angle` up to whole turns that lies in the range, or else its nearer end.
/// Sets `inside`.
double nearestAngle(double angle, const std::pair<double, double>& range, bool& inside);

}  // namespace leeway::robots
