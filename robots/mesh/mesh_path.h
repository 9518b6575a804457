#pragma once

#include <string>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// Returns the file for `uri` in a URDF at `urdf_path`: file:///..., an absolute path, one relative
/// to the URDF's folder, or package://NAME/REST (model:// is the same). A package is searched in
/// options.packages; in ROS_PACKAGE_PATH and AMENT_PREFIX_PATH, and Gazebo's GAZEBO_MODEL_PATH,
/// GZ_SIM_RESOURCE_PATH and SDF_PATH; in the URDF's folder and those above it, by their own names
/// and their package.xml; and in their sibling folders, in the same way. A folder of that name
/// whose package.xml has another comes last, with a warning. If two siblings have the name, a
/// warning names both, unless one is a link to the other. %20 is a space, unless the file's name
/// contains it. Throws InputError with the places that were searched. Other files that name meshes
/// are handled the same way.
std::string resolveMesh(const std::string& uri, const std::string& urdf_path, int line,
                        const LoadOptions& options, std::vector<std::string>* warnings = nullptr);

/// The same for other files that robot files name: `what` is what messages call them, "model".
std::string resolveFile(const std::string& uri, const std::string& what,
                        const std::string& urdf_path, int line, const LoadOptions& options,
                        std::vector<std::string>* warnings = nullptr);

}  // namespace leeway::robots
