#pragma once

// Private to the layers above collision/: how a loaded mesh is interpreted.

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

/// The entry of LoadOptions::meshes under the first of `names` that has one (the owner of the mesh,
/// then the path of its file as written); null if there is none. Marks all of them as found.
const MeshTreatment* treatmentOf(const LoadOptions& options,
                                 std::initializer_list<std::string_view> names);

/// Returns a mesh rebuilt as treatmentOf() specifies; `shape` if there is no entry, and for other
/// shapes. Throws collision::InvalidShape.
collision::Shape treatedMesh(const collision::Shape& shape,
                             std::initializer_list<std::string_view> names,
                             const LoadOptions& options);

/// The meshes that were probably meant as solids but are not closed, by their owners.
class OpenMeshes {
 public:
  /// Counts the open edges of all meshes among the geometries, including deforming ones.
  void add(std::string_view owner, std::span<const collision::Geometry> geometries);
  bool isEmpty() const { return open_.empty(); }
  /// One sentence about all of them, which names the key that decides, or the means `of_program`s;
  /// empty if there are none.
  std::string text(bool of_program) const;

 private:
  std::vector<std::pair<std::string, std::size_t>> open_;
  std::string rigid_;  // the first one that does not deform
};

}  // namespace leeway::robots
