#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "leeway/collision/shape.h"
#include "tools/view/pack.h"

namespace leeway::tools::view {

using Triangle = std::array<std::int32_t, 3>;

/// A mesh for display. Every point of the true mesh is shown within `error` of its place [m].
/// Thinner parts may vanish.
struct DisplayMesh {
  std::vector<Eigen::Vector3d> vertices;  // [m]
  std::vector<Triangle> triangles;
  double error = 0;
};

/// Reduces a mesh to about `most` triangles. Merges the vertices in one cell of a grid into one of
/// them (J. Rossignac, P. Borrel, "Multi-resolution 3D approximations for rendering complex
/// scenes", 1993), so that no point moves farther than the cell's diagonal. O(n log n).
DisplayMesh decimated(std::span<const Eigen::Vector3d> vertices,
                      std::span<const Triangle> triangles, std::size_t most);

/// The mesh of a shape: the own triangles of hulls, meshes and deforming shapes, an inscribed
/// polyhedron for round shapes; empty for a half-space. Hulls and meshes are decimated.
DisplayMesh displayMesh(const collision::Shape& shape, std::size_t most);

/// Coordinates as whole numbers of steps from the lower corner of a box.
struct Quantised {
  Eigen::Vector3d low;  // [m]
  double step;          // [m]
  std::vector<std::uint16_t> numbers;
};
/// Uses steps of 0.1 mm, or larger ones if 16 bits require it. The error is half the diagonal of a
/// box with edges of one step.
Quantised quantised(std::span<const Eigen::Vector3d> points);
double quantisationError(const Quantised& q);  // [m]

/// The meshes of a page. Stores each mesh once, even if it is used several times.
class MeshStore {
 public:
  /// `budget`: the approximate number of triangles of all meshes together.
  MeshStore(Pack& pack, std::size_t budget) : pack_(pack), budget_(budget) {}
  /// The number of a shape's mesh.
  int add(const collision::Shape& shape);
  /// The number of a mesh that belongs to no shape.
  int add(const DisplayMesh& mesh, std::size_t triangles_before);
  /// All meshes, for the document.
  const Json& document() const { return meshes_; }
  std::size_t triangles() const { return triangles_; }
  double largestError() const { return error_; }  // [m]

 private:
  Pack& pack_;
  std::size_t budget_, triangles_ = 0;
  double error_ = 0;
  std::unordered_map<const void*, int> by_owner_;
  std::unordered_map<std::string, int> by_content_;
  Json meshes_ = Json::array();
};

}  // namespace leeway::tools::view
