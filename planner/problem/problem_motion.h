#pragma once

#include <memory>
#include <string>
#include <vector>

#include "leeway/collision/vertex_motion.h"
#include "planner/problem/indexed_mesh.h"
#include "planner/problem/yaml_reader.h"

namespace leeway::planner {

/// Most cells of a generated grid: two million triangles; more are a mistake.
inline constexpr int kMostGridCells = 1'000'000;

/// `file` and `scale` of a map: an OBJ, whose vertices keep their numbers.
IndexedMesh readVertices(const YamlReader& map);

/// `motion:` of a deforming obstacle whose vertices rest at `rest`.
std::shared_ptr<const collision::VertexMotion> readMotion(const YamlReader& motion,
                                                          const IndexedMesh& rest,
                                                          std::vector<std::string>& warnings);

}  // namespace leeway::planner
