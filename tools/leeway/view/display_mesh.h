#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "leeway/collision/shape.h"
#include "tools/leeway/view/pack.h"

namespace leeway::tools::view {

using Triangle = std::array<std::int32_t, 3>;

/// A mesh to look at: no point of the true one is shown farther than `error` from its place [m].
/// What is thinner than that may vanish.
struct DisplayMesh {
  std::vector<Eigen::Vector3d> vertices;  // [m]
  std::vector<Triangle> triangles;
  double error = 0;
};

/// At most about `most` triangles: vertices in one cell of a grid become one of them (J. Rossignac,
/// P. Borrel, "Multi-resolution 3D approximations for rendering complex scenes", 1993), so that no
/// point moves farther than the cell's diagonal. O(n log n).
DisplayMesh decimated(std::span<const Eigen::Vector3d> vertices,
                      std::span<const Triangle> triangles, std::size_t most);

/// The mesh of a shape: what it is made of for hulls, meshes and deforming ones, an inscribed
/// polyhedron for round ones; nothing for a half-space. Hulls and meshes are decimated.
DisplayMesh displayMesh(const collision::Shape& shape, std::size_t most);

/// Coordinates as whole numbers of steps from the lower corner of a box.
struct Quantised {
  Eigen::Vector3d low;  // [m]
  double step;          // [m]
  std::vector<std::uint16_t> numbers;
};
/// Steps of 0.1 mm, or as fine as 16 bits allow; the error is half the box's diagonal of one step.
Quantised quantised(std::span<const Eigen::Vector3d> points);
double quantisationError(const Quantised& q);  // [m]

/// The meshes of a page, each once however often it is used.
class MeshStore {
 public:
  /// `budget`: triangles of all meshes together, about.
  MeshStore(Pack& pack, std::size_t budget) : pack_(pack), budget_(budget) {}
  /// The number of a shape's mesh.
  int add(const collision::Shape& shape);
  /// Also of a mesh that no shape holds.
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
