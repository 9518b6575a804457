#pragma once

#include <string>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// The file of `uri` in a URDF at `urdf_path`: package://NAME/REST (searched for in
/// options.packages, ROS_PACKAGE_PATH, the URDF's folder and its parents), file:///..., an absolute
/// path, or one relative to the URDF's folder. Throws InputError that names every place tried. The
/// same for other files that name meshes.
std::string resolveMesh(const std::string& uri, const std::string& urdf_path, int line,
                        const LoadOptions& options);

}  // namespace leeway::robots
