#pragma once

// Private to robots/mjcf: the settings of a file, and poses as they are written under them.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "leeway/collision/pose.h"
#include "robots/mjcf/mjcf_attributes.h"

namespace leeway::robots {

using collision::Pose;

/// The settings of <compiler>, and those of <option> that decide which bodies collide.
struct MjcfSettings {
  bool degrees = true;
  std::string euler = "xyz";  ///< axes of euler angles: of the turned frame; capitals: fixed
  std::string mesh_folder;
  bool strips_paths = false;
  bool auto_limits = true;
  bool filters_parents = true;  ///< a body does not collide with its parent

  double angle(double written) const;  ///< [rad]
};

MjcfSettings readSettings(const MjcfFile& file);

/// `pos` and the one attribute that gives an orientation.
Pose poseOf(const Attributes& attributes, const MjcfSettings& settings);
/// The rotation of `angle` [rad] about an axis of any length but 0.
Eigen::Matrix3d rotationAbout(const Eigen::Vector3d& axis, double angle);
/// The shortest rotation of the z axis onto a direction of any length but 0; opposite to it, half a
/// turn about x.
Eigen::Matrix3d rotationOfZ(const Eigen::Vector3d& direction);
/// The rotation of w x y z of any length but 0.
Eigen::Matrix3d rotationOf(const std::vector<double>& quaternion);

}  // namespace leeway::robots
