#pragma once

#include "robots/urdf/urdf_document.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

/// Whether a file is an SDF (of Gazebo or Drake).
bool isSdf(const XmlFile& file);

/// Reads the one model of an SDF, with the models in it, into the same document as a URDF. Names of
/// nested models are MODEL::NAME. A link that turns about an axis beside its origin has a link
/// LINK/JOINT before it. Links that are joined to the world, or do not stand at its origin, follow
/// a link "world". `with_visuals`: also UrdfLink's visuals; those that cannot be read are left out.
/// Throws InputError.
UrdfDocument readSdf(XmlFile& file, const LoadOptions& options, bool with_visuals = false);

}  // namespace leeway::robots
