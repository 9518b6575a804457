#pragma once

#include "robots/urdf/urdf_document.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

/// Whether a file holds a robot of MuJoCo's.
bool isMjcf(const XmlFile& file);

/// Reads MuJoCo's XML, with the files that it includes, into the same document as a URDF: bodies
/// are links; a body with several joints, or with one beside its origin, has a link for each, named
/// BODY/JOINT. What planning does not need is left out; one warning counts it. `with_visuals`: also
/// UrdfLink's visuals, the geoms that MuJoCo's viewer shows by default (groups 0 to 2); those that
/// cannot be read are left out. Throws InputError.
UrdfDocument readMjcf(XmlFile& file, const LoadOptions& options, bool with_visuals = false);

}  // namespace leeway::robots
