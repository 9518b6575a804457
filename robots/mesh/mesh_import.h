#pragma once

// Private to the layers above collision/: mesh files as shapes.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "leeway/collision/shape.h"
#include "leeway/robots/stopped.h"
#include "robots/cache/disk_cache.h"

namespace leeway::robots {

/// Files of fewer bytes are read in less than a tenth of a second, without asking whether to stop.
inline constexpr std::uintmax_t kWorthAsking = std::uintmax_t{1} << 20;

struct ImportedMesh {
  collision::Shape shape;
  /// The ContentKey of all that it depends on; empty where that is not known, or nothing is kept.
  std::string key;
  std::vector<std::string> warnings;  ///< each with the referrer, and the mesh file's own line
};

/// loadMesh(), with a cache for what it makes. Several threads call `stop`.
ImportedMesh importMesh(const std::string& path, const Eigen::Vector3d& scale,
                        const std::string& referrer, int line, const DiskCache& cache,
                        const Stop& stop);

/// A mesh whose vertices keep the numbers that they have in their file.
struct IndexedMesh {
  std::vector<Eigen::Vector3d> vertices;  ///< [m]
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::string> warnings;
};

/// A Wavefront OBJ file, its polygons cut, its vertices scaled. Throws like loadMesh().
IndexedMesh importIndexed(const std::string& path, const Eigen::Vector3d& scale,
                          const std::string& referrer, int line);

/// A mesh file as OMPL.app sees it: turned by its up axis, to Assimp's y. Nothing is kept of it.
/// Throws like loadMesh().
ImportedMesh importForOmplApp(const std::string& path, const std::string& referrer, int line);

/// Where OMPL.app has the origin of a body of that mesh, in the mesh's coordinates [m]: the mean of
/// the vertices that Assimp keeps apart by their normals, in single precision. Throws like
/// loadMesh().
Eigen::Vector3d originForOmplApp(const std::string& path, const std::string& referrer, int line);

}  // namespace leeway::robots
