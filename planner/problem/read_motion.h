#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/collision/vertex_motion.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/model.h"
#include "planner/yaml/yaml_reader.h"
#include "robots/mesh/mesh_import.h"

namespace leeway::planner {

/// Largest number of cells of a generated grid (two million triangles). A larger one is a mistake.
inline constexpr int kMostGridCells = 1'000'000;

/// Reads `file` and `scale` of a map: an OBJ, whose vertices keep their order. `load` has packages.
robots::IndexedMesh readVertices(const YamlReader& map, const robots::LoadOptions& load);

/// Reads `motion:` of a deforming obstacle whose vertices rest at `rest`.
std::shared_ptr<const collision::VertexMotion> readMotion(const YamlReader& motion,
                                                          const robots::IndexedMesh& rest,
                                                          const robots::LoadOptions& load,
                                                          std::vector<std::string>& warnings);

/// Reads `moving:` of all in `objects:`, which the world already has. They then
/// stand where they are at the start of the execution.
void readObjectMotions(const YamlReader& objects, Problem& problem);

/// `skinned:`, bones that carry the vertices (read_skinning.cc).
std::shared_ptr<const collision::VertexMotion> readSkinned(const YamlReader& skinned,
                                                           const std::vector<Eigen::Vector3d>& rest,
                                                           std::vector<std::string>& warnings);

/// Reads `cache:`, a PC2 or MDD file, distinguished by its ending. `start` shifts it in time
/// (read_cache.cc).
std::shared_ptr<const collision::VertexMotion> readCache(const YamlReader& cache,
                                                         const std::vector<Eigen::Vector3d>& rest);

/// Reads `interpolation:` of a map with keys: linear by default, or smooth.
collision::Interpolation readInterpolation(const YamlReader& map);

/// The number of a key; `otherwise` without the key.
double optionalNumber(const YamlReader& map, std::string_view key, double otherwise);

}  // namespace leeway::planner
