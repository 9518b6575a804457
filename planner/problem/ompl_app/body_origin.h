#pragma once

#include <Eigen/Core>
#include <string>

namespace leeway::planner {

/// The origin that OMPL.app uses for a body with this mesh, in the mesh's coordinates [m]: the mean
/// of the vertices that Assimp, its reader, separates by their normals, with the up axis turned to
/// y, in single precision. Throws robots::InputError that names `referrer`:`line`.
Eigen::Vector3d bodyOrigin(const std::string& mesh, const std::string& referrer, int line);

}  // namespace leeway::planner
