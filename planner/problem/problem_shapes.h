#pragma once

#include <string>
#include <vector>

#include "leeway/collision/scene.h"
#include "planner/problem/yaml_reader.h"

namespace leeway::planner {

/// The rotation of a unit quaternion xyzw.
Eigen::Matrix3d rotationFromQuaternion(const Eigen::Vector4d& xyzw);

/// The unit quaternion xyzw of turns about the fixed axes x, then y, then z (URDF's rpy) [rad].
Eigen::Vector4d quaternionFromRpy(const Eigen::Vector3d& rpy);

/// A quaternion xyzw, normalised. Up to 1e-3 from unit length is mended (with a warning above
/// 1e-8), more is an error.
Eigen::Vector4d readQuaternion(const YamlReader& reader, std::vector<std::string>& warnings);

/// `orientation` (quaternion) or `rpy` of a map as a quaternion xyzw; no turn where neither is
/// there, an error where both are.
Eigen::Vector4d readOrientation(const YamlReader& map, std::vector<std::string>& warnings);

/// `position` and one of `orientation` and `rpy` of a map; the identity where they are absent.
collision::Pose readPose(const YamlReader& map, std::vector<std::string>& warnings);

/// The one shape that a map names, with its pose. `owner` names the object for messages and the
/// geometry.
collision::Geometry readGeometry(const YamlReader& map, const std::string& name,
                                 std::vector<std::string>& warnings);

/// `shapes:`, a list of at least one shape, or the single shape that stands in the map itself (in
/// the map's own frame).
std::vector<collision::Geometry> readGeometries(const YamlReader& map, const std::string& owner,
                                                std::vector<std::string>& warnings);

/// A path named in a YAML file: absolute, or relative to that file's folder.
std::string resolvedPath(const YamlReader& reader);

}  // namespace leeway::planner
