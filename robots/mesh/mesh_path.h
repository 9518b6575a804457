#pragma once

#include <string>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// The file of `uri` in a URDF at `urdf_path`: file:///..., an absolute path, one relative to the
/// URDF's folder, or package://NAME/REST (model:// is the same). A package is looked for in
/// options.packages; ROS_PACKAGE_PATH and AMENT_PREFIX_PATH; the URDF's folder and those above it,
/// by their own names and their package.xml; and folders beside these, in the same way. %20 is a
/// space, unless the file's name has it. Throws InputError that says where it looked. The same for
/// other files that name meshes.
std::string resolveMesh(const std::string& uri, const std::string& urdf_path, int line,
                        const LoadOptions& options);

}  // namespace leeway::robots
