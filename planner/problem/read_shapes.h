#pragma once

#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/octree.h"
#include "leeway/planner/problem.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {

/// The rotation of a unit quaternion xyzw.
Eigen::Matrix3d rotationFromQuaternion(const Eigen::Vector4d& xyzw);

/// The unit quaternion xyzw of turns about the fixed axes x, then y, then z (URDF's rpy) [rad].
Eigen::Vector4d quaternionFromRpy(const Eigen::Vector3d& rpy);

/// A unit quaternion xyzw. A length within kMendableQuaternion of 1 is normalised, with a warning
/// above kSilentQuaternion; any other is an error.
Eigen::Vector4d readQuaternion(const YamlReader& reader, std::vector<std::string>& warnings);

/// The same of the numbers x y z w that stand at `reader`.
Eigen::Vector4d unitQuaternion(const YamlReader& reader, const std::vector<double>& xyzw,
                               std::vector<std::string>& warnings);

/// `orientation` (quaternion) or `rpy` of a map, as a quaternion xyzw. Neither: the identity. Both:
/// an error.
Eigen::Vector4d readOrientation(const YamlReader& map, std::vector<std::string>& warnings);

/// `position`, and `orientation` or `rpy`, of a map. Absent ones are the identity's.
collision::Pose readPose(const YamlReader& map, std::vector<std::string>& warnings);

/// The one shape of a map, with its pose. `name` is the geometry's unless the map has one.
collision::Geometry readGeometry(const YamlReader& map, const std::string& name,
                                 std::vector<std::string>& warnings,
                                 const robots::LoadOptions& load);

/// `shapes:`, a list of at least one shape, or the single shape in the map itself, in the map's own
/// frame. `owner` names geometries without a name.
std::vector<collision::Geometry> readGeometries(const YamlReader& map, const std::string& owner,
                                                std::vector<std::string>& warnings,
                                                const robots::LoadOptions& load);

/// `scale` of a map, one factor or three; ones without it.
Eigen::Vector3d readScale(const YamlReader& map);

/// `cloud:` of an object: its points with their radius, before any filter.
std::shared_ptr<const PointCloud> readCloud(const YamlReader& cloud,
                                            std::vector<std::string>& warnings,
                                            const robots::Stop& stop);

/// `octree:` of an object: the boxes of a file, named `owner`. Adds to `warnings` how many they
/// are, and what unseen space counts as.
std::vector<collision::Geometry> readOctree(const YamlReader& octree, const std::string& owner,
                                            std::vector<std::string>& warnings,
                                            const robots::Stop& stop);

/// The boxes of an octree, named `owner`, with a warning at `place` as readOctree() has it.
std::vector<collision::Geometry> namedOctree(const YamlReader& place,
                                             std::vector<collision::Geometry> boxes,
                                             const std::string& owner, Unseen unseen,
                                             std::vector<std::string>& warnings);

/// Applies the filters of `cloud:` to the cloud of `object`: carves out what `carve` names (links,
/// objects, held objects; already looked up), crops, thins in both ways. `problem` has all but
/// goals that need the cloud: its start and its objects.
void filterCloud(const YamlReader& cloud, const std::vector<std::string>& carve,
                 const Problem& problem, Object& object);

/// A path named in a YAML file: absolute, or relative to that file's folder.
std::string resolvedPath(const YamlReader& reader);

}  // namespace leeway::planner
