#pragma once

#include "robots/urdf/urdf_document.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

/// Whether a file holds a robot of MuJoCo's.
bool isMjcf(const XmlFile& file);

/// Reads MuJoCo's XML, with the files that it includes, into the same document as a URDF: bodies
/// are links; a body with several joints, or with one beside its origin, has a link for each, named
/// BODY/JOINT. What planning does not need is left out; one warning counts it. Throws InputError.
UrdfDocument readMjcf(XmlFile& file, const LoadOptions& options);

}  // namespace leeway::robots
