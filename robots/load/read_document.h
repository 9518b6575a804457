#pragma once

// Private to robots/load.

#include "robots/urdf/urdf_document.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

/// Reads a URDF, MJCF or SDF file, as its root element says. `with_visuals`: also UrdfLink's
/// visuals; those that cannot be read are left out. Throws InputError.
UrdfDocument readDocument(XmlFile& file, const LoadOptions& options, bool with_visuals);

}  // namespace leeway::robots
