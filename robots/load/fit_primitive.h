#pragma once

// Private to robots/load: primitives that MuJoCo fits to meshes (mjCMesh of its
// src/user/user_mesh.cc).

#include "robots/mesh/mesh_import.h"
#include "robots/urdf/urdf_document.h"

namespace leeway::robots {

/// The primitive of a geometry with `fit`: with sizes, and placed on the link. `mesh`: its mesh as
/// in the file, not scaled. The same as MuJoCo's to rounding. Throws InputError for a mesh without
/// volume. O(triangles).
UrdfCollision fittedPrimitive(const UrdfCollision& geometry, const IndexedMesh& mesh);

}  // namespace leeway::robots
