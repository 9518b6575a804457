#pragma once

// Private to robots/mjcf: the settings of a file, and poses as they are written under them.

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
  bool fits_bounds = false;     ///< primitives go around the meshes that they are fitted to
  bool exact_inertia = false;   ///< of meshes, in files of older versions
  bool filters_parents = true;  ///< a body does not collide with its parent

  double angle(double written) const;  ///< [rad]
};

MjcfSettings readSettings(const MjcfFile& file);

/// `pos` and the one attribute that gives an orientation.
Pose poseOf(const Attributes& attributes, const MjcfSettings& settings);

}  // namespace leeway::robots
