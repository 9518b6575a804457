#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/octree.h"
#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// The rotation of a unit quaternion xyzw.
Eigen::Matrix3d rotationFromQuaternion(const Eigen::Vector4d& xyzw);

/// The unit quaternion xyzw of rotations about the fixed axes x, then y, then z (URDF's rpy) [rad].
Eigen::Vector4d quaternionFromRpy(const Eigen::Vector3d& rpy);

/// Reads a unit quaternion xyzw. Normalises one whose length is within kMendableQuaternion of 1,
/// and warns if it is off by more than kSilentQuaternion. Any other length is an error.
Eigen::Vector4d readQuaternion(const YamlReader& reader, std::vector<std::string>& warnings);

/// The same for the numbers x y z w that were read at `reader`.
Eigen::Vector4d unitQuaternion(const YamlReader& reader, const std::vector<double>& xyzw,
                               std::vector<std::string>& warnings);

/// Reads `orientation` (quaternion) or `rpy` of a map as a quaternion xyzw. Returns the identity if
/// the map has neither. Both together are an error.
Eigen::Vector4d readOrientation(const YamlReader& map, std::vector<std::string>& warnings);

/// Reads `position`, and `orientation` or `rpy`, of a map. The default is the identity.
collision::Pose readPose(const YamlReader& map, std::vector<std::string>& warnings);

/// Reads the one shape of a map, with its pose. `name` is the geometry's name unless the map has
/// one.
collision::Geometry readGeometry(const YamlReader& map, const std::string& name,
                                 std::vector<std::string>& warnings,
                                 const robots::LoadOptions& load);

/// Reads `shapes:`, a list of at least one shape, or the single shape in the map itself, in the
/// map's frame. `owner` names geometries without a name.
std::vector<collision::Geometry> readGeometries(const YamlReader& map, const std::string& owner,
                                                std::vector<std::string>& warnings,
                                                const robots::LoadOptions& load);

/// Reads `color`: red, green and blue, each from 0 to 1.
std::array<double, 3> readColor(const YamlReader& color);

/// `scale` of a map, one factor or three; ones by default.
Eigen::Vector3d readScale(const YamlReader& map);

/// Reads `cloud:` of an object: its points with their radius, before any filter, and what counts as
/// occupied because the camera did not see it.
void readCloud(const YamlReader& cloud, Object& object, std::vector<std::string>& warnings,
               const robots::Stop& stop);

/// Reads `octree:` of an object: the boxes of a file, named `owner`. Adds a warning with their
/// number and with what unseen space counts as.
std::vector<collision::Geometry> readOctree(const YamlReader& octree, const std::string& owner,
                                            std::vector<std::string>& warnings,
                                            const robots::Stop& stop);

/// Names the boxes of an octree `owner`, and adds the warning of readOctree() for `place`.
std::vector<collision::Geometry> namedOctree(const YamlReader& place,
                                             std::vector<collision::Geometry> boxes,
                                             const std::string& owner, Unseen unseen,
                                             std::vector<std::string>& warnings);

/// Applies the filters of `cloud:` to the cloud of `object`: removes points inside the bodies in
/// `carve` (links, objects and attached objects that were looked up), crops, and thins in both
/// ways. `problem` must have its start and its objects; goals are not needed.
void filterCloud(const YamlReader& cloud, const std::vector<std::string>& carve,
                 const Problem& problem, Object& object);

/// A path named in a YAML file: absolute, or relative to that file's folder.
std::string resolvedPath(const YamlReader& reader);

/// The path of a mesh file: as resolvedPath(), or what a URI such as package://NAME/PATH stands for
/// (robots::resolveMesh()). Packages are searched from the YAML file's folder up.
std::string meshPath(const YamlReader& reader, const robots::LoadOptions& load,
                     std::vector<std::string>& warnings);

}  // namespace leeway::planner
