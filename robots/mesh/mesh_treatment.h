#pragma once

// Private to the layers above collision/: what a loaded mesh is taken for.

#include <cstddef>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "leeway/collision/shape.h"
#include "leeway/robots/model.h"

namespace leeway::robots {

/// The entry of LoadOptions::meshes under the first of `names` that has one (what owns the mesh,
/// then the path of its file as it is written), marked as found; null without one.
const MeshTreatment* treatmentOf(const LoadOptions& options,
                                 std::initializer_list<std::string_view> names);

/// Returns a mesh as treatmentOf() has it, built again; without an entry, and for other shapes,
/// `shape`. Throws collision::InvalidShape.
collision::Shape treatedMesh(const collision::Shape& shape,
                             std::initializer_list<std::string_view> names,
                             const LoadOptions& options);

/// The meshes that were likely meant as solids and are not closed, by their owners.
class OpenMeshes {
 public:
  /// Counts the open edges of those of the geometries that are meshes, deforming ones included.
  void add(std::string_view owner, std::span<const collision::Geometry> geometries);
  /// One sentence about all of them, which says which key decides; empty without any.
  std::string text() const;

 private:
  std::vector<std::pair<std::string, std::size_t>> open_;
};

}  // namespace leeway::robots
