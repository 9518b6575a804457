#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

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
};

/// loadMesh(), with a cache for what it makes. `stop` is asked from several threads.
ImportedMesh importMesh(const std::string& path, const Eigen::Vector3d& scale,
                        const std::string& referrer, int line, const DiskCache& cache,
                        const Stop& stop);

struct CenteredMesh {
  collision::Shape shape;
  Eigen::Vector3d center;  ///< mean of the vertices that Assimp keeps apart by their normals [m]
};

/// A mesh file as OMPL.app sees it: turned by its up axis, to Assimp's y. Throws like loadMesh().
CenteredMesh importForOmplApp(const std::string& path, const std::string& referrer, int line);

}  // namespace leeway::robots
