#pragma once

// How far a frame is outside a PoseRegion, with the data that a solver needs to move it inside.

#include <Eigen/Core>
#include <optional>
#include <string>

#include "leeway/robots/inverse_kinematics.h"

namespace leeway::robots {

/// A region with data that its searches reuse.
struct PreparedRegion {
  explicit PreparedRegion(const PoseRegion& region);

  std::array<std::pair<double, double>, 3> position, rpy;
  bool exact_turn = false;  // one rotation
  bool any_turn = false;    // all rotations
  Eigen::Matrix3d target;   // of exact_turn
};

/// In the region's frame R: the frame's position minus the nearest allowed one.
struct RegionError {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< rotation vector
  /// Coordinates inside their range, in which a small move costs nothing.
  std::array<bool, 3> free_position = {false, false, false};
  /// Orthonormal axes about which a small turn costs nothing.
  int free_turns = 0;
  std::array<Eigen::Vector3d, 3> free_axis;
};

/// Returns the fault of a region, with the accepted values: a link that the model does not have, a
/// frame that is not rigid, a range whose ends are swapped or not finite, a tolerance below
/// kLeastPoseTolerance. nullopt for a valid region.
std::optional<std::string> regionFault(const Model& model, const PoseRegion& region);

RegionError regionError(const PreparedRegion& region, const Pose& X_RF);

/// The rotation vector of R, its length in [0, pi].
Eigen::Vector3d rotationVector(const Eigen::Matrix3d& R);

/// The angle equal to `angle` up to whole turns that lies in the range, or otherwise its nearer
/// end. Sets `inside`.
double nearestAngle(double angle, const std::pair<double, double>& range, bool& inside);

}  // namespace leeway::robots
