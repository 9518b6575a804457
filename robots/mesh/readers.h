#pragma once

// Private to robots/: readers of mesh files. Each returns the complete contents of a file, with
// coordinates exactly as they are written (decimal numbers correctly rounded, single precision
// widened). On an error it throws InputError with the file's line or byte, and returns no partial
// contents. Linear in the file's size.

#include "robots/mesh/file_mesh.h"
#include "robots/mesh/mesh_source.h"

namespace leeway::robots {

/// Stereolithography, as text or binary. Facets with more than three corners are polygons.
MeshContents readStl(const MeshSource& source);

/// Wavefront OBJ: `v` and `f`. Lines, points and curves are counted; other statements are ignored.
MeshContents readObj(const MeshSource& source);

/// Polygon file format, as text or binary: vertices, faces and strips of triangles.
MeshContents readPly(const MeshSource& source);

/// Collada: geometries below the nodes of the visual scene. In metres, by the file's unit; its up
/// axis is ignored, as RViz does.
MeshContents readDae(const MeshSource& source);

/// The rotation by which Assimp, OMPL.app's reader, turns a Collada file's up axis to y. Identity
/// for other files.
Eigen::Matrix3d upAxisToY(const MeshSource& source);

/// glTF 2.0 and GLB: triangles, strips and fans below the nodes of the file's scene, in metres; the
/// up axis is ignored. Quantised coordinates are converted. Skins, weights of morph targets and
/// required extensions that may change shapes are errors. `reads_others`: whether numbers came from
/// other files.
MeshContents readGltf(const MeshSource& source, bool& reads_others);

/// The text of a note about a file with animations.
inline constexpr const char* kAnimated =
    "has animations; they are ignored, and nodes stay where the file has them";

}  // namespace leeway::robots
