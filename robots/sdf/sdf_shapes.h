#pragma once

// Private to robots/sdf: what collides.

#include <optional>

#include "robots/sdf/sdf_frames.h"
#include "robots/urdf/urdf_document.h"

namespace leeway::robots {

/// Reads a <collision> or <visual> of a link (a frame). Nothing if it is <empty>. The plane of a
/// <visual> is a box without a height. Throws InputError.
std::optional<UrdfCollision> readShape(const tinyxml2::XMLElement& element, const SdfFrames& frames,
                                       int link);

}  // namespace leeway::robots
