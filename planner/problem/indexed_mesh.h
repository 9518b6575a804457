#pragma once

// Private to planner/: meshes whose vertices have to keep their numbers.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "leeway/collision/deformable_mesh.h"

namespace leeway::planner {

/// Vertices and triangles by number.
struct IndexedMesh {
  std::vector<Eigen::Vector3d> vertices;  // [m]
  std::vector<collision::DeformableMesh::Triangle> triangles;
};

/// The `v` and `f` lines of a Wavefront OBJ, vertices in the order of the file (Assimp, which reads
/// the meshes that are rigid, hands them out in an order of its own); polygons become fans. Throws
/// robots::InputError with file and line.
IndexedMesh readObj(const std::string& file);

/// A rectangle of `size` in the plane z = 0, its middle at the origin, in cells of two triangles.
/// Vertices row by row, x fastest. All arguments positive.
IndexedMesh gridMesh(double size_x, double size_y, int cells_x, int cells_y);

}  // namespace leeway::planner
