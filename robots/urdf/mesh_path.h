#pragma once

#include <string>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// The file that a URDF at `urdf_path` means by `uri`: package://NAME/REST (searched in
/// options.packages, ROS_PACKAGE_PATH, the URDF's folder and its parents), file:///..., an absolute
/// path, or one relative to the URDF's folder. Throws InputError naming every place tried.
std::string resolveMesh(const std::string& uri, const std::string& urdf_path, int line,
                        const LoadOptions& options);

}  // namespace leeway::robots
