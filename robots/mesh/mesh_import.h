#pragma once

// Private to the layers above collision/: imports mesh files as shapes.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "leeway/collision/shape.h"
#include "leeway/robots/stopped.h"
#include "robots/cache/disk_cache.h"

namespace leeway::robots {

/// Smaller files are read in less than a tenth of a second, without calling `stop` [B].
inline constexpr std::uintmax_t kWorthAsking = std::uintmax_t{1} << 20;

struct ImportedMesh {
  collision::Shape shape;
  /// The ContentKey of all data that the mesh depends on; empty if that is unknown, or if there is
  /// no cache.
  std::string key;
  std::vector<std::string> warnings;  ///< each with the referrer and the line in the mesh file
};

/// loadMesh() with a cache for its results. Several threads call `stop`.
ImportedMesh importMesh(const std::string& path, const Eigen::Vector3d& scale,
                        const std::string& referrer, int line, const DiskCache& cache,
                        const Stop& stop);

/// The vertices and triangles of a mesh file.
struct IndexedMesh {
  std::vector<Eigen::Vector3d> vertices;  ///< [m]
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::string> warnings;
  std::vector<std::string> face_warnings = {};  ///< importIndexed(): of faces that were cut
};

/// Reads a Wavefront OBJ file, triangulates its polygons and scales its vertices, which keep their
/// numbers in the file. Throws like loadMesh().
IndexedMesh importIndexed(const std::string& path, const Eigen::Vector3d& scale,
                          const std::string& referrer, int line);

/// Reads the triangles of a mesh file, of any format, in metres and scaled, without a hierarchy
/// over them. Not cached. Throws like loadMesh(), and Stopped.
IndexedMesh importTriangles(const std::string& path, const Eigen::Vector3d& scale,
                            const std::string& referrer, int line, const Stop& stop);

/// Reads a mesh file as OMPL.app does: turned from its up axis to y. The result is not cached.
/// Throws like loadMesh().
ImportedMesh importForOmplApp(const std::string& path, const std::string& referrer, int line);

}  // namespace leeway::robots
